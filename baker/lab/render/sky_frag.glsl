#version 450 core
/* The sky, where there is no surface. */
layout(binding = 0) uniform sampler2D depths;
layout(binding = 1) uniform sampler2D map; /* rows from the zenith down; its middle is along x */
uniform mat4 point_from_depth;
uniform vec4 sizes; /* width and height of the picture, turn in parts of a full turn, factor on radiance */
layout(location = 0) out vec4 sky_out;

const float turn = 6.28318531;

void main()
{
    if (texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r > 0.0) discard;
    vec3  way    = normalize((point_from_depth * vec4(gl_FragCoord.xy / sizes.xy, 0.0, 1.0)).xyz);
    float across = way.xz == vec2(0.0) ? 0.0 : atan(way.z, way.x);
    vec2  at     = vec2(0.5 + across / turn + sizes.z, acos(clamp(way.y, -1.0, 1.0)) / (0.5 * turn));
    sky_out      = vec4(sizes.w * textureLod(map, at, 0.0).rgb, 0.0);
}
