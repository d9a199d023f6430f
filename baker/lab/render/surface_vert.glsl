#version 450 core
/* Triangles, each with its own corners, since normal and colour are per triangle. */
layout(location = 0) in vec3 position; /* from the scene's middle */
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 colour;
layout(location = 3) in vec2 uv;
uniform mat4 clip_from_scene;
uniform vec3 eye; /* from the scene's middle */
out vec3 way;
flat out vec3 face_normal;
flat out vec3 albedo;
out vec2 hole;

void main()
{
    gl_Position = clip_from_scene * vec4(position, 1.0);
    way         = position - eye;
    face_normal = normal;
    albedo      = colour.rgb * colour.rgb;
    hole        = uv;
}
