#version 450 core
/* A light's mesh, three vertices for each triangle, so that each fragment knows its distance from the edges. */
layout(std430, binding = 5) readonly buffer mesh {
    uint words[]; /* corners, then places */
};
uniform mat4 clip_from_ls;
uniform int  first_place; /* word of it */
out vec3 beside;

void main()
{
    int place   = first_place + 3 * int(words[gl_VertexID]);
    gl_Position = clip_from_ls * vec4(uintBitsToFloat(words[place]), uintBitsToFloat(words[place + 1]), uintBitsToFloat(words[place + 2]), 1.0);
    beside      = vec3(equal(ivec3(gl_VertexID % 3), ivec3(0, 1, 2)));
}
