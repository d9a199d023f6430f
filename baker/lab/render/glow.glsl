/* Emissive surfaces, where they are visible: their depth equals that of the scene. */
#ifdef VERTEX
/* A parallelogram as a strip, its corner, its sides. */
uniform mat4 clip_from_scene;
uniform vec3 corner, across, up;
out vec2 part;

void main()
{
    part        = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    gl_Position = clip_from_scene * vec4(corner + part.x * across + part.y * up, 1.0);
}
#else
layout(binding = 0) uniform sampler2D depths;
layout(binding = 1) uniform sampler2D colours; /* and the factor on radiance */
uniform vec3 radiance;
in vec2 part;
layout(location = 0) out vec4 glow_out;

void main()
{
    float seen = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r;
    if (abs(seen - gl_FragCoord.z) > 1e-3 * seen) discard;
    glow_out = vec4(radiance * texture(colours, part).rgb, 0.0);
}
#endif
