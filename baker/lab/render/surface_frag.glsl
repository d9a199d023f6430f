#version 450 core
/* What a pixel shows: the normal of the side that is seen, and its colour. Where it is, is in the depth. */
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
