#define VXS_HLSL
ByteAddressBuffer words : register(t0);
#define vxs_word(dag, i) words.Load(4u * ((dag) + (i)))

#include "vxs_lookup.h"
#include "vxs_lookup_blocks.h"
#include "vxs_space.h"

cbuffer shadow_light : register(b0) { vxs_light_constants light; };

float main(float3 position_ws : POSITION_WS, float3 normal_ws : NORMAL_WS) : SV_Target
{
    return vxs_lit(light.first_word, light, position_ws, normal_ws, vxs_box(9));
}
