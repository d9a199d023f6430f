#version 450 core
/* A parallelogram as a strip, its corner, its sides. */
uniform mat4 clip_from_scene;
uniform vec3 corner, across, up;
out vec2 part;

void main()
{
    part        = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = clip_from_scene * vec4(corner + part.x * across + part.y * up, 1.0);
}
