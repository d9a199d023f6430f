/* The surface at a pixel: the normal of the visible side, and its colour. Its position follows from the depth. */
#ifdef VERTEX
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
#else
layout(binding = 0) uniform sampler2D alpha;
uniform float threshold; /* of the alpha mask; 0: no holes */
in vec3 way;
flat in vec3 face_normal;
flat in vec3 albedo;
in vec2 hole;
layout(location = 0) out vec4 normal_out;
layout(location = 1) out vec4 albedo_out;

void main()
{
    if (threshold > 0.0 && textureLod(alpha, hole, 0.0).r < threshold) discard;
    normal_out = vec4(dot(face_normal, way) > 0.0 ? -face_normal : face_normal, 0.0);
    albedo_out = vec4(albedo, 1.0);
}
#endif
