/* A transparent view of a light's mesh, with its edges, where neither the scene hides it nor rays have ended: warm where a ray
 * from the eye enters the light, cold where it leaves it. Mesh surfaces within a few texels of a scene's surface are visible,
 * too. */
#ifdef VERTEX
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
#else
layout(binding = 0) uniform sampler2D depths; /* near / distance along the axis, as gl_FragCoord.z */
uniform float farthest; /* in the same units */
uniform int   turn;     /* 1, or -1: the view mirrors light space */
in vec3 beside;
layout(location = 0) out vec4 light;

const float on_surface = 0.015, veil = 0.07, edge = 0.3;
const vec3 enters = vec3(1.0, 0.45, 0.08), leaves = vec3(0.06, 0.4, 1.0);

void main()
{
    vec3  wide = fwidth(beside), pixels = beside / max(wide, vec3(1e-6)); /* the width of a pixel, and the distance of the edges
                                                                             in pixels */
    float nearest = min(pixels.x, min(pixels.y, pixels.z)), widest = max(wide.x, max(wide.y, wide.z));
    float seen = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r;
    if (gl_FragCoord.z < max((1.0 - on_surface) * seen, farthest)) discard;
    float line = (1.0 - smoothstep(0.4, 1.2, nearest)) * clamp(1.5 - 2.0 * widest, 0.0, 1.0); /* none in tiny triangles */
    light      = vec4((gl_FrontFacing == (turn > 0) ? leaves : enters) * (veil + edge * line), 0.0);
}
#endif
