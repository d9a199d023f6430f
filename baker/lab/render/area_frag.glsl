#version 450 core
/* Light of area lights on surfaces, in the units of light before exposure. */
layout(binding = 0) uniform sampler2D irradiance;
uniform float factor;
layout(location = 0) out vec4 light_out;

void main()
{
    light_out = vec4(factor * texelFetch(irradiance, ivec2(gl_FragCoord.xy), 0).rgb, 0.0);
}
