/* Fog from a command line.
 * SPDX-License-Identifier: GPL-3.0-or-later */
#ifndef FOG_CHOICE_H
#define FOG_CHOICE_H

#include "baker/base/run_context.h"
#include "baker/lab/render/fog_pass.h"

typedef struct fog_choice {
    double   per_metre, albedo, anisotropy, top_metres;
    fog_by   by;
    uint32_t steps, grid;
    int      is_half, given, albedo_given, anisotropy_given, top_given, by_given, steps_given, grid_given;
} fog_choice;

/* Typical fog is water drops: they absorb little, and scatter light forward. */
#define FOG_DEFAULTS                                                                                                               \
    {                                                                                                                              \
        .albedo = 0.9, .anisotropy = 0.4, .by = FOG_BY_INTERVALS, .steps = 64                                                      \
    }

/* choice  a fog_choice, FOG_DEFAULTS before */
/* clang-format off */
#define FOG_ROWS(choice)                                                                                                           \
    {"--fog", OPTION_F64, &(choice).per_metre, 0, 1e6, NULL, "PER_METRE",                                                          \
     "fog that takes so much of light in a metre: 0.01 leaves a third after 110 m", &(choice).given},                              \
    {"--fog-albedo", OPTION_F64, &(choice).albedo, 0, 1, NULL, "SHARE",                                                            \
     "how much of that turns instead of being absorbed, 0 to 1 (default 0.9)", &(choice).albedo_given},                            \
    {"--fog-anisotropy", OPTION_F64, &(choice).anisotropy, -0.99, 0.99, NULL, "G",                                                 \
     "-0.99, light turns back, to 0.99, it goes on (default 0.4)", &(choice).anisotropy_given},                                    \
    {"--fog-top", OPTION_F64, &(choice).top_metres, -1e7, 1e7, NULL, "Y",                                                          \
     "fog lies on the ground, to this height (default everywhere)", &(choice).top_given},                                          \
    {"--fog-by", OPTION_CHOICE, &(choice).by, 0, 0, FOG_BY_CHOICES, NULL,                                                          \
     "with OpenGL: lookups at even steps of each ray, or at steps that scatter alike; what is lit, exactly; a mesh of what is lit, made once; or a "  \
     "grid of light rays (default intervals)", &(choice).by_given},     \
    {"--fog-steps", OPTION_U32, &(choice).steps, 1, 65536, NULL, "N",                                                              \
     "of march or angles, and of lights that smoke dims or that see what moves, 1 to 65536 (default 64)", &(choice).steps_given},  \
    {"--fog-grid", OPTION_U32, &(choice).grid, 16, 1024, NULL, "N",                                                                \
     "of grid: N x 2N x N voxels, 16 to 1024 (default 256, with egl 512)", &(choice).grid_given},                                \
    {"--fog-half", OPTION_SWITCH, &(choice).is_half, 0, 0, NULL, NULL, "with OpenGL: a ray for 2 x 2 samples", NULL}
/* clang-format on */

/* Returns VXS_OK, or VXS_E_ARGUMENT for options that have no effect without --fog, or with the chosen way to find shadows. */
vxs_result fog_check(const fog_choice *c, run_context *m);

/* The same check for the number of steps. Lights of moving casters or smoke always take steps; call this only if there are none.
 * others  the end of the error line: alternatives, or the reason */
vxs_result fog_check_steps(const fog_choice *c, const char *others, run_context *m);

fog_medium fog_of(const fog_choice *c);

#endif
