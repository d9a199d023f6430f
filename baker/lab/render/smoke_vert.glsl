#version 450 core
/* A quad in front of each capsule, of two triangles, with the light at its corners. */
layout(std430, binding = 6) readonly restrict buffer corners_block { vec4 corners[]; }; /* four of each; metres from the eye */
layout(binding = 3) uniform sampler2D corner_lights; /* row by row, as the corners */
uniform mat4 clip_from_eye;
out vec3 way;
out vec3 light;
flat out int capsule;

void main()
{
    const int corner_of[6] = int[6](0, 1, 2, 2, 1, 3);
    int       wide = textureSize(corner_lights, 0).x, n = 4 * (gl_VertexID / 6) + corner_of[gl_VertexID % 6];
    capsule     = gl_VertexID / 6;
    way         = corners[n].xyz;
    light       = texelFetch(corner_lights, ivec2(n % wide, n / wide), 0).rgb;
    gl_Position = clip_from_eye * vec4(way, 1.0);
}
