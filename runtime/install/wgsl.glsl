// Lookups of vxs in WGSL: vxs_lookup.h, vxs_lookup_blocks.h, vxs_space.h and vxs_smoke.h, in vxs_intervals.wgsl also
// vxs_depths.h and vxs_intervals.h, and in vxs_fog.wgsl fog.glsl with what it needs, which naga translated (make wgsl). Their comments describe the functions; out parameters are
// pointers. The includer defines how a word is read:
//
//     @group(0) @binding(0) var<storage, read> words: array<u32>; // the words of all lights, one light after the other
//     fn vxs_word_at(at: u32) -> u32 { return words[at]; }
//
//     let lit = vxs_lit(light.first_word, light, position_ws, normal_ws, vxs_box(9));
//
// SPDX-License-Identifier: MIT
#version 450
#extension GL_GOOGLE_include_directive : require
uint vxs_word_at(uint at)
{
    return at;
}
#define vxs_word(dag, i) vxs_word_at((dag) + (i))

#ifdef WITH_fog /* tables hold palette blocks */
#define VXS_GL_TABLES
#undef VXS_ONLY_CODING
#define VXS_ONLY_CODING 2
#define VXS_ONLY_EVERYWHERE
#include "tables.glsl"
#endif
#include "vxs_lookup.h"
#include "vxs_lookup_blocks.h"
#include "vxs_space.h"
#include "vxs_smoke.h"
#if defined(WITH_intervals) || defined(WITH_fog)
#include "vxs_depths.h"
#include "vxs_intervals.h"

const int VXS_SPAN_LIT_ = VXS_SPAN_LIT, VXS_SPAN_SHADOW_ = VXS_SPAN_SHADOW, VXS_SPAN_OUTSIDE_ = VXS_SPAN_OUTSIDE;
#endif

#ifdef WITH_fog
#include "vxs_air_path.h"
#include "fog.glsl"
#endif

const float VXS_OUTSIDE_ = VXS_OUTSIDE; /* naga leaves out the _ */

void main()
{
}
