/* Recognizes common file formats that vxs does not read by their first bytes, to give the user advice in the error message.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOREIGN_FILE_H
#define FOREIGN_FILE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { FOREIGN_BYTES = 160, FOREIGN_LOOKED_AT = 4096 };

/* Name of a file's format, and what to do with it: "FBX (export it as glTF, .glb)".
 * text         [out]
 * bytes        [size] the first bytes of the file: FOREIGN_LOOKED_AT, or all if there are fewer
 * total_bytes  size of the whole file; 0: unknown
 * Returns text, or NULL for an unknown format. */
const char *foreign_file_text(char text[FOREIGN_BYTES], const void *bytes, size_t size, uint64_t total_bytes);

/* 1 when a file with these first bytes may be glTF: a GLB, or JSON in an encoding with one byte per character. */
int may_be_gltf(const uint8_t *bytes, size_t size);

#ifdef __cplusplus
}
#endif
#endif
