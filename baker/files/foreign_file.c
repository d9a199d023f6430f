/* Recognizes other file formats; see foreign_file.h.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#include "baker/files/foreign_file.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

#define EXPORT "export it as glTF, .glb"

/* Formats by their first bytes. */
static const struct {
    const char *magic;
    uint8_t     size;
    const char *text;
} binary[] = {
    {"Kaydara FBX Binary", 18, "FBX (" EXPORT ")"},
    {"BLENDER", 7, "a Blender file (" EXPORT ")"},
    {"PXR-USDC", 8, "USD (" EXPORT ")"},
    {"\x1f\x8b", 2, "compressed with gzip (decompress it, or give <(zcat FILE))"},
    {"\x28\xb5\x2f\xfd", 4, "compressed with zstd (decompress it, or give <(zstdcat FILE); of a Blender file, " EXPORT ")"},
    {"BZh", 3, "compressed with bzip2 (decompress it, or give <(bzcat FILE))"},
    {"\xfd\x37zXZ", 5, "compressed with xz (decompress it, or give <(xzcat FILE))"},
    {"7z\xbc\xaf\x27\x1c", 6, "a 7-Zip archive (unpack it)"},
    {"Rar!", 4, "a RAR archive (unpack it)"},
    {"\xd0\xcf\x11\xe0", 4, "a 3ds Max or Office file (" EXPORT ")"},
    {"MM\0\x2a", 4, "a TIFF picture"},
    {"II\x2a\0", 4, "a TIFF picture"},
    {"FOR4", 4, "a Maya file (" EXPORT ")"},
    {"FOR8", 4, "a Maya file (" EXPORT ")"},
    {"Ogawa", 5, "Alembic (" EXPORT ")"},
    {"DRACO", 5, "a bare Draco stream (glTF holds it: " EXPORT ")"},
    {"AC10", 4, "DWG (" EXPORT ")"},
    {"\xc1\x83\x2a\x9e", 4, "an Unreal asset (" EXPORT ")"},
    {"RSRC", 4, "a Godot resource (" EXPORT ")"},
    {"RSCC", 4, "a Godot resource (" EXPORT ")"},
    {"pnts", 4, "pnts of 3D Tiles, points, of which there are no triangles"},
    {"\xff\xd8\xff", 3, "a JPEG picture"},
    {"\xabKTX ", 5, "a KTX picture"},
    {"DDS ", 4, "a DDS picture"},
    {"\x76\x2f\x31\x01", 4, "an OpenEXR picture"},
    {"GIF8", 4, "a GIF picture"},
    {"%PDF", 4, "PDF"},
    {"\177ELF", 4, "a program"},
    {"NRRD000", 7, "a grid in NRRD, which --smoke takes"},
};

/* Text formats by their first word, in upper or lower case, after an optional byte order mark and white space. */
static const struct {
    const char *word, *text;
} texts[] = {
    {"version https://git-lfs", "a Git LFS pointer, which stands for the file (git lfs pull fetches it)"},
    {"; FBX", "FBX (" EXPORT ")"},
    {"#usda", "USD (" EXPORT ")"},
    {"<!DOCTYPE html", "an HTML page (what was to be fetched is behind it, or the address is wrong)"},
    {"<html", "an HTML page (what was to be fetched is behind it, or the address is wrong)"},
    {"[gd_scene", "a Godot scene (" EXPORT ")"},
    {"[gd_resource", "a Godot resource (" EXPORT ")"},
    {"%YAML", "YAML, as Unity's scenes are (" EXPORT ")"},
    {"//Maya ASCII", "a Maya file (" EXPORT ")"},
    {"ply\n", "PLY (" EXPORT ")"},
    {"ply\r", "PLY (" EXPORT ")"},
    {"ISO-10303-21", "STEP or IFC (" EXPORT ")"},
    {"#VRML", "VRML (" EXPORT ")"},
    {"xof ", "DirectX .x (" EXPORT ")"},
};

static uint32_t u32_at(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* A tile of 3D Tiles has a header, tables whose lengths the header gives, and a GLB. A composite tile is a sequence of such
 * tiles. */
static int is_tile(char text[FOREIGN_BYTES], const uint8_t *b, size_t size)
{
    int      instances = size >= 32 && !memcmp(b, "i3dm", 4), batched = size >= 28 && !memcmp(b, "b3dm", 4);
    uint64_t at = instances ? 32 : 28;
    if (size >= 16 && !memcmp(b, "cmpt", 4)) {
        snprintf(text, FOREIGN_BYTES, "a composite of 3D Tiles (its first tile begins at byte 16: tail -c +17 FILE)");
        return 1;
    }
    if (!instances && !batched) return 0;
    for (size_t n = 12; n < 28; n += 4) at += u32_at(b + n);
    if (instances && !u32_at(b + 28))
        snprintf(text, FOREIGN_BYTES, "i3dm of 3D Tiles (it names a glTF file, which begins to be named at byte %llu)",
                 (unsigned long long)at);
    else
        snprintf(text, FOREIGN_BYTES, "%.4s of 3D Tiles (its glTF begins at byte %llu: tail -c +%llu FILE > scene.glb)",
                 (const char *)b, (unsigned long long)at, (unsigned long long)at + 1);
    return 1;
}

/* Text with two bytes per character, with or without a byte order mark: for example, written by a PowerShell pipe. */
static int is_utf16(const uint8_t *b, size_t size)
{
    if (size < 4) return 0;
    return (b[0] == 0xff && b[1] == 0xfe) || (b[0] == 0xfe && b[1] == 0xff) || (b[0] == '{' && !b[1] && b[2]) ||
           (!b[0] && b[1] == '{' && !b[2]);
}

/* The first line of a Wavefront file that is not a comment defines a vertex, a group or a material. */
static int is_obj(const char *text)
{
    static const char *const words[] = {"v ", "vn ", "vt ", "o ", "g ", "mtllib ", "usemtl ", "s "};
    while (*text == '#' || *text == '\n' || *text == '\r') text += *text == '#' ? strcspn(text, "\n") : 1;
    for (size_t n = 0; n < sizeof words / sizeof *words; n++)
        if (!strncmp(text, words[n], strlen(words[n]))) return 1;
    return 0;
}

/* text  ends at a NUL; in a binary file this is its first zero byte */
static const char *text_kind(const char *text)
{
    if (!strncmp(text, "\xef\xbb\xbf", 3)) text += 3;
    text += strspn(text, " \t\r\n");
    for (size_t n = 0; n < sizeof texts / sizeof *texts; n++)
        if (!strncasecmp(text, texts[n].word, strlen(texts[n].word))) return texts[n].text;
    if (!strncmp(text, "<?xml", 5) || !strncmp(text, "<COLLADA", 8))
        return strstr(text, "<COLLADA")    ? "COLLADA (" EXPORT ")"
               : strcasestr(text, "<html") ? "an HTML page (what was to be fetched is behind it, or the address is wrong)"
               : strstr(text, "<X3D")      ? "X3D (" EXPORT ")"
                                           : "XML (" EXPORT ")";
    if (!strncasecmp(text, "solid", 5) && strstr(text, "facet")) return "STL (" EXPORT ")";
    return is_obj(text) ? "OBJ (" EXPORT ")" : NULL;
}

const char *foreign_file_text(char text[FOREIGN_BYTES], const void *bytes, size_t size, uint64_t total_bytes)
{
    char           head[FOREIGN_LOOKED_AT + 1];
    const uint8_t *b     = bytes;
    const char    *found = NULL;
    size_t         kept  = size < FOREIGN_LOOKED_AT ? size : FOREIGN_LOOKED_AT;
    if (size) memcpy(head, bytes, kept);
    head[kept] = '\0';
    if (is_tile(text, b, size)) return text;
    if (size >= 30 && !memcmp(b, "PK\3\4", 4)) {
        /* in a ZIP archive the name of the first file is at byte 30 */
        size_t length = (size_t)b[26] | (size_t)b[27] << 8;
        if (length > size - 30) length = size - 30;
        found = memmem(b + 30, length, ".usd", 4) ? "USDZ (" EXPORT ")" : "a ZIP archive (unpack it)";
    }
    for (size_t n = 0; n < sizeof binary / sizeof *binary && !found; n++)
        if (size >= binary[n].size && !memcmp(b, binary[n].magic, binary[n].size)) found = binary[n].text;
    if (!found && is_utf16(b, size)) found = "text in UTF-16 (iconv -f UTF-16 -t UTF-8 makes it UTF-8)";
    if (!found) found = text_kind(head);
    /* a binary STL has 80 arbitrary bytes, the number of triangles, and 50 bytes per triangle */
    if (!found && size >= 84 && u32_at(b + 80) && total_bytes == 84 + 50 * (uint64_t)u32_at(b + 80)) found = "STL (" EXPORT ")";
    if (!found && size >= 64 && !b[0] && !memcmp(b, b + 1, size - 1))
        found = "nothing but zeros (its copy is incomplete, or it is a device)";
    if (!found) return NULL;
    snprintf(text, FOREIGN_BYTES, "%s", found);
    return text;
}

int may_be_gltf(const uint8_t *bytes, size_t size)
{
    size_t at = size >= 3 && !memcmp(bytes, "\xef\xbb\xbf", 3) ? 3 : 0;
    if (size >= 12 && !memcmp(bytes, "glTF", 4)) return 1;
    while (at < size && bytes[at] && strchr(" \t\r\n", bytes[at])) at++;
    return at < size && bytes[at] == '{' && !(at + 1 < size && !bytes[at + 1]);
}
