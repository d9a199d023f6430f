/* Findings: everything that can be wrong with a .vxs file. One list of stable numbers, the result of each, and its text
 * (formats/vxs.md section 8). Numbers are only appended within their hundred, and never reused.
 * Public.
 * SPDX-License-Identifier: MIT */
#ifndef VXS_FINDINGS_H
#define VXS_FINDINGS_H

/* clang-format off */
#define VXS_FINDINGS(X)                                                                                \
    X(101, VXS_E_TRUNCATED, "the file is shorter than a header")                                       \
    X(102, VXS_E_NOT_VXS,   "the file does not start with the magic bytes of a .vxs file")             \
    X(103, VXS_E_VERSION,   "the format version is not one that this reader knows")                    \
    X(104, VXS_E_CORRUPT,   "the checksum of the header does not match")                               \
    X(105, VXS_E_CORRUPT,   "reserved bytes of the header are not zero")                               \
    X(106, VXS_E_TRUNCATED, "the file is shorter than its header says")                                \
    X(107, VXS_E_CORRUPT,   "the file is longer than its header says")                                 \
    X(108, VXS_E_CORRUPT,   "the number of sections is out of range")                                  \
    X(109, VXS_E_CORRUPT,   "the checksum of the directory does not match")                            \
    X(201, VXS_E_CORRUPT,   "a section has flags that are not defined")                                \
    X(202, VXS_E_CORRUPT,   "a section does not start where the one before it ends")                   \
    X(203, VXS_E_CORRUPT,   "a section ends beyond the end of the file")                               \
    X(204, VXS_E_CORRUPT,   "bytes follow the last section")                                           \
    X(205, VXS_E_VERSION,   "a section that is not optional has a kind that this reader does not know") \
    X(206, VXS_E_CORRUPT,   "the checksum of a section does not match")                                \
    X(207, VXS_E_CORRUPT,   "a section is not one zstd frame of the size that the directory says")     \
    X(208, VXS_E_CORRUPT,   "a section is there twice")                                                \
    X(209, VXS_E_CORRUPT,   "a section is missing")                                                    \
    X(210, VXS_E_CORRUPT,   "a section belongs to a light or a level that is not there")               \
    X(211, VXS_E_MEMORY,    "the file needs more memory than the limit allows")                        \
    X(212, VXS_E_CORRUPT,   "a section is not stored in the way of its kind")                          \
    X(301, VXS_E_CORRUPT,   "the light table has a size that its count does not give")                 \
    X(302, VXS_E_VERSION,   "a light has a kind that this reader does not know")                       \
    X(303, VXS_E_CORRUPT,   "a light's number of levels is out of range")                              \
    X(304, VXS_E_CORRUPT,   "a light's transform is not finite or not invertible")                     \
    X(305, VXS_E_CORRUPT,   "a light's texel size, voxel size or direction is out of range")           \
    X(306, VXS_E_CORRUPT,   "a light's name is empty, not terminated or not unique")                   \
    X(307, VXS_E_CORRUPT,   "reserved bytes or undefined flags of a light are not zero")               \
    X(308, VXS_E_CORRUPT,   "a light's near distance, cone or range is not one of its kind")           \
    X(309, VXS_E_VERSION,   "a light has a coding that this reader does not know")                     \
    X(310, VXS_E_VERSION,   "a light has a packing that this reader does not know")                    \
    X(401, VXS_E_CORRUPT,   "a level has a size that its node count does not give")                    \
    X(402, VXS_E_CORRUPT,   "a node repeats a neighbour that is not there")                            \
    X(403, VXS_E_CORRUPT,   "a node refers to a child beyond those seen so far")                       \
    X(404, VXS_E_CORRUPT,   "a level or the masks hold other nodes than are referred to")              \
    X(405, VXS_E_CORRUPT,   "a reference is not written in the shortest form")                         \
    X(406, VXS_E_CORRUPT,   "a light's word count is not that of its sections")                        \
    X(501, VXS_E_CORRUPT,   "a light's resident part breaks a rule of its layout")                     \
    X(502, VXS_E_CORRUPT,   "a light's pages have a size that their table does not give")              \
    X(503, VXS_E_CORRUPT,   "the checksum of a page does not match")                                   \
    X(504, VXS_E_CORRUPT,   "a page breaks a rule of its layout")                                      \
    X(505, VXS_E_CORRUPT,   "a page is not one zstd frame of the size that its table says")            \
    X(601, VXS_E_CORRUPT,   "a light's smoke has a size that its head and counts do not give")         \
    X(602, VXS_E_CORRUPT,   "the head of a light's smoke is out of range")                             \
    X(603, VXS_E_CORRUPT,   "a tile of smoke has no curve, or one of too many nodes")                  \
    X(604, VXS_E_CORRUPT,   "a curve of smoke leaves the range of depths or of transmittance")         \
    X(701, VXS_E_CORRUPT,   "the points have a size that their count does not give")                   \
    X(702, VXS_E_CORRUPT,   "the head of the points is out of range")                                  \
    X(703, VXS_E_CORRUPT,   "a point leaves the range of coordinates")
/* clang-format on */

#endif
