/* Files of kinds that vxs does not read, by their first bytes: people hand them over by mistake, and want to know what to do.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOREIGN_FILE_H
#define FOREIGN_FILE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { FOREIGN_BYTES = 160, FOREIGN_LOOKED_AT = 4096 };

/* What a file is, and what to do with it: "FBX (export it as glTF, .glb)".
 * text         [out]
 * bytes        [size] its first ones, FOREIGN_LOOKED_AT where it has as many
 * total_bytes  of the whole file; 0: not known
 * Returns text, or NULL where it is none of the kinds that are known here. */
const char *foreign_file_text(char text[FOREIGN_BYTES], const void *bytes, size_t size, uint64_t total_bytes);

/* Whether a file that begins so may be glTF: a GLB, or JSON in an encoding of one byte a letter. */
int may_be_gltf(const uint8_t *bytes, size_t size);

#ifdef __cplusplus
}
#endif
#endif
