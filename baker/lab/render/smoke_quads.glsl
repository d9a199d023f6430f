/* A capsule over the picture, and over the fog behind it. Its transmittance follows from the length of the eye ray in it before
 * the scene, so that its intersection with surfaces is soft. Follows capsule.glsl. */
#ifdef VERTEX
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
#else
struct drawn_capsule {
    vec4 begin;  /* metres from the eye, and the radius */
    vec4 end;    /* and extinction */
    vec4 albedo;
};
layout(std430, binding = 5) readonly restrict buffer capsules_block { drawn_capsule capsules[]; };
layout(binding = 0) uniform sampler2D depths;   /* near / distance along the axis */
layout(binding = 1) uniform sampler2D airlight; /* of the fog, up to the surface */
uniform vec4 lights;     /* exposure; near */
uniform vec4 ambient;    /* light from all directions, exposed */
uniform vec4 extinction; /* of the fog, and its top relative to the eye */
uniform vec4 turned;     /* the fog's factor on such light, and the end of rays that meet no surface, metres */
in vec3 way;
in vec3 light;
flat in int capsule;
layout(location = 0) out vec4 colour_out;

/* The metres in the fog, of the first `metres` from the eye, along a ray with this slope. */
float in_fog(float slope, float metres)
{
    float top = extinction.w;
    if (top >= 0.0) return slope * metres > top ? top / slope : metres;
    return slope * metres < top ? metres - top / slope : 0.0;
}

void main()
{
    drawn_capsule c = capsules[capsule];
    float         depth = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r, size = length(way), near;
    float         end = depth > 0.0 ? lights.y / depth * size * gl_FragCoord.w : turned.w; /* gl_FragCoord.w: 1 / distance along the
                                                                                              axis */
    vec3          direction = way / size;
    vec2          part = vxs_capsule_part(c.begin.xyz, c.end.xyz - c.begin.xyz, c.begin.w, direction, near) + near;
    part = vec2(max(part.x, 0.0), min(part.y, end));
    if (!(part.y > part.x)) discard;
    float alpha = 1.0 - exp(-c.end.w * (part.y - part.x));
    vec3  left = exp(-extinction.rgb * in_fog(direction.y, 0.5 * (part.x + part.y))), all = exp(-extinction.rgb * in_fog(direction.y, end));
    vec3  share = (1.0 - left) / max(1.0 - all, vec3(1e-6)); /* the share of the air up to the surface that is before the smoke */
    vec3  air = texelFetch(airlight, ivec2(gl_FragCoord.xy), 0).rgb + turned.rgb * (1.0 - all);
    vec3  sent = c.albedo.rgb * (0.25 * lights.x * light + ambient.rgb); /* equally in all directions */
    colour_out = alpha * vec4(sent * left + air * min(share, vec3(1.0)), 1.0);
}
#endif
