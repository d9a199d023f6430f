#version 450 core
/* The surface at a pixel: the normal of the visible side, and its colour. Its position follows from the depth. */
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
