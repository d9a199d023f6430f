/* How exit depths are found, and what rendering took.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef EXIT_DEPTH_H
#define EXIT_DEPTH_H

#include <stdint.h>

typedef enum exit_mode {
    EXIT_AUTO, /* peel where solids meet, as casters_find_meeting knows them: the same depths as EXIT_PEEL */
    EXIT_PEEL, /* exit depth of the union of solids, by depth peeling */
    EXIT_BACK  /* the nearest back face: never behind the true exit, often before it */
} exit_mode;

typedef struct depth_stats {
    uint64_t blocks_rendered, blocks_empty; /* blocks are the squares that are rendered at once */
    uint64_t blocks_peeled;                 /* of those rendered */
    uint64_t blocks_not_peeled;             /* of those rendered: they have solids, and none that needs it */
    uint64_t triangles_drawn;               /* over all passes */
    uint64_t peel_passes;                   /* over all blocks */
    uint32_t peel_passes_max;               /* of the block that took most */
} depth_stats;

#endif
