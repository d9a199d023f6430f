#version 450 core
/* Emissive surfaces, where they are visible: their depth equals that of the scene. */
layout(binding = 0) uniform sampler2D depths;
layout(binding = 1) uniform sampler2D colours; /* and the factor on radiance */
uniform vec3 radiance;
in vec2 part;
layout(location = 0) out vec4 glow_out;

void main()
{
    float seen = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r;
    if (abs(seen - gl_FragCoord.z) > 1e-3 * seen) discard;
    glow_out = vec4(radiance * texture(colours, part).rgb, 0.0);
}
