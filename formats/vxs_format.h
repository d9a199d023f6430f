/* Numbers of the .vxs format: magic, offsets, limits. #defines only.
 * The meaning of each is in formats/vxs.md, which is normative; tests/cli/test_format.py checks one against the other.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_FORMAT_H
#define VXS_FORMAT_H

#define VXS_FORMAT_VERSION        2 /* the latest; a file has the lowest version that has all of its features */
#define VXS_FORMAT_VERSION_BLOCKS 2 /* the first with codings, and with sections that are not zstd frames */

/* vxs.md section 3: header */
#define VXS_MAGIC                 "\x8fVXS\r\n\x1a\n"
#define VXS_MAGIC_BYTES           8
#define VXS_HEADER_BYTES          64
#define VXS_HEADER_VERSION        8
#define VXS_HEADER_SECTION_COUNT  12
#define VXS_HEADER_FILE_BYTES     16
#define VXS_HEADER_DIRECTORY_HASH 24
#define VXS_HEADER_RESERVED       32
#define VXS_HEADER_HASH           56

/* vxs.md section 4: directory */
#define VXS_ENTRY_BYTES          48
#define VXS_ENTRY_KIND           0
#define VXS_ENTRY_FLAGS          4
#define VXS_ENTRY_LIGHT          8
#define VXS_ENTRY_LEVEL          12
#define VXS_ENTRY_OFFSET         16
#define VXS_ENTRY_STORED_BYTES   24
#define VXS_ENTRY_INFLATED_BYTES 32
#define VXS_ENTRY_HASH           40

#define VXS_KIND_LIGHTS      0x5448474cu /* "LGHT" */
#define VXS_KIND_LEVEL       0x4c56454cu /* "LEVL" */
#define VXS_KIND_MASKS       0x4b53414du /* "MASK" */
#define VXS_KIND_RESIDENT    0x54445352u /* "RSDT" */
#define VXS_KIND_PAGES       0x45474150u /* "PAGE" */
#define VXS_KIND_METADATA    0x4154454du /* "META" */
#define VXS_KIND_SMOKE       0x454b4d53u /* "SMKE" */
#define VXS_KIND_POINTS      0x53544e50u /* "PNTS" */
#define VXS_SECTION_OPTIONAL 1u          /* entry flag: a reader that does not know the kind skips the section */
#define VXS_SECTION_STORED   2u          /* entry flag: the stored bytes are the content, not a zstd frame; from version 2 on */
#define VXS_NO_LIGHT         0xffffffffu /* entry belongs to the file, not to one light */

/* vxs.md section 5: lights */
#define VXS_LIGHTS_PREFIX_BYTES    8
#define VXS_LIGHT_BYTES            256
#define VXS_LIGHT_KIND             0
#define VXS_LIGHT_LEVELS           4
#define VXS_LIGHT_WORD_COUNT       8
#define VXS_LIGHT_FLAGS            12
#define VXS_LIGHT_LS_FROM_WS       16
#define VXS_LIGHT_TEXEL_METRES     112
#define VXS_LIGHT_VOXEL_METRES     120
#define VXS_LIGHT_DIRECTION        128
#define VXS_LIGHT_NEAR_METRES      152
#define VXS_LIGHT_COS_OUTER        160
#define VXS_LIGHT_RANGE_METRES     168
#define VXS_LIGHT_CODING           176 /* from version 2 on; in version 1 all lights are DAGs, and this is 0 */
#define VXS_LIGHT_PACKING          180 /* of palette blocks; else 0 */
#define VXS_LIGHT_RESERVED         184
#define VXS_LIGHT_NAME             192
#define VXS_LIGHT_NAME_BYTES       64
#define VXS_LIGHT_KIND_DIRECTIONAL 1u
#define VXS_LIGHT_KIND_SPOT        2u
#define VXS_LIGHT_KIND_POINT       3u
#define VXS_LIGHT_BOUNDED          1u /* flag: the volume ends at the map's near and far sides */
#define VXS_LIGHT_CUBE             2u /* flag: six maps, one for each face of a cube about the light */
#define VXS_CUBE_FACES             6u

/* how the words of a light store its maps; each is a section of vxs.md */
#define VXS_CODING_DAG    1u /* a graph of nodes and masks, section 6 */
#define VXS_CODING_BLOCKS 2u /* palette blocks, section 13 */

/* How the pages of palette blocks are stored */
#define VXS_PACKING_SMALL 0u /* coded with adaptive odds, vxs.md 14.1 to 14.8 */
#define VXS_PACKING_FAST  1u /* words compressed by zstd, 14.10 */
#define VXS_PACKING_FINE  2u /* the same with more contexts, for fine maps, 14.11 */

/* vxs.md section 14: the pages of palette blocks */
#define VXS_PAGES_PREFIX_BYTES 8
#define VXS_PAGE_BYTES         16
#define VXS_PAGE_STORED_BYTES  0
#define VXS_PAGE_WORD_COUNT    4
#define VXS_PAGE_HASH          8
#define VXS_BLOCKS_FIRST_PAGE  8u /* words of a light before its table of pages */
#define VXS_BLOCKS_SPARE_WORDS 4u /* zeros behind the words of a light, which lookups may read */

/* vxs.md section 15: baked smoke */
#define VXS_SMOKE_PREFIX_BYTES 16
#define VXS_SMOKE_LEVELS       0
#define VXS_SMOKE_FIRST_METRES 4
#define VXS_SMOKE_STEP_METRES  8
#define VXS_SMOKE_NODE_COUNT   12

/* vxs.md section 16: points of casters */
#define VXS_POINTS_PREFIX_BYTES  44
#define VXS_POINTS_SQUARE_METRES 0
#define VXS_POINTS_LOW           8
#define VXS_POINTS_STEP_METRES   32
#define VXS_POINTS_POINT_COUNT   40
#define VXS_POINT_CODE_BYTES     6

/* vxs.md section 9: limits */
#define VXS_SECTIONS_MAX 20480u
#define VXS_LIGHTS_MAX   1024u
#define VXS_LEVELS_MIN   3u  /* a map of 8 x 8 texels: the root is a slice node */
#define VXS_LEVELS_MAX   18u /* a map of 262144 x 262144 texels */
#define VXS_FILTER_MAX   17  /* widest filter of a lookup, texels */

#define VXS_SMOKE_LEVELS_MAX 13u /* maps of 8192 x 8192 curves */
#define VXS_SMOKE_NODES_MAX  16u /* of a curve */
#define VXS_POINTS_MAX       0x400000u

/* vxs.md section 6: state of a child of a node, two bits each */
#define VXS_CHILD_LIT    0u
#define VXS_CHILD_SHADOW 1u
#define VXS_CHILD_OWN    2u /* the node stores an offset for it */
#define VXS_CHILD_SAME   3u /* the same as its neighbour nearer the light */

#endif
