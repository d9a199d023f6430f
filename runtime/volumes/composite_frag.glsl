/* Blends the frame's fog over what was drawn: airlight, scattered ambient light, and the transmittance of each channel. */
#include "frame.glsl"

layout(location = 0, index = 0) out vec4 airlight;
layout(location = 0, index = 1) out vec4 left;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float metres;
    vec3  direction = vxs_eye_ray(pixel, metres), part;
    vec2  in_fog = vec2(0.0, metres);
    if (VXS_AIR_HAS_TOP(vxs_frame.sizes.w)) vxs_air_in_fog(vxs_frame.eye_far.y, direction.y, vxs_frame.sizes.w, in_fog);
    vxs_air_left(vxs_frame_medium(), max(in_fog.y - in_fog.x, 0.0), part);
    vec3 turned = vxs_frame.scattering.rgb / max(vxs_frame.extinction.rgb, vec3(1e-30)) * (1.0 - part);
    airlight = vec4(texelFetch(vxs_airlight, pixel, 0).rgb + vxs_frame.ambient.rgb * turned, 0.0);
    left     = vec4(part, 1.0);
}
