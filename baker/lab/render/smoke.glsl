/* The transmittance of smoke towards a light at a pixel's surface: pictures of smoke_pass.c. */
layout(std430, binding = 7) readonly restrict buffer smoke_block { int smoke_layers[]; }; /* of each light; -1: no smoke dims it */
layout(binding = 7) uniform sampler2DArray smoke_pictures;

float smoke_left(uint light, ivec2 pixel)
{
    int layer = smoke_layers[light];
    return layer < 0 ? 1.0 : texelFetch(smoke_pictures, ivec3(pixel, layer), 0).r;
}
