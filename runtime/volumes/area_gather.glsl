/* Light of all lamps, or of each ninth, in the air and on surfaces, of each pixel, or of each second both ways. map: how many are gathered across and up;
 * counts: lamps, which (vxs_area_gather), 1 to look up between rows, the side of curves of smoke; knobs: runs, and what surfaces are moved by, in columns and bits. */
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform writeonly restrict image2DArray gathered; /* air, and how far it goes; surfaces */
layout(binding = VXS_AT_OTHER) uniform highp sampler2D vxs_normals;

#ifdef VXS_GRID_DIMS
float vxs_area_left(uint lamp, vec3 at)
{
    float left = 1.0;
#ifdef VXS_USES_CURVES
    left = vxs_area_curves_left(lamp, at);
#endif
#ifdef VXS_AREA_BAKED
    float baked = vxs_area.lamps[lamp].colour.w;
    if (baked > 0.0) left *= vxs_smoke_left_by(uint(baked) - 1u, at);
#endif
    return left;
}
#endif

struct gathering {
    vec3       eye, direction, normal; /* normal 0: there is no surface */
    float      metres;
    vxs_medium medium;
    vec3       air, surface;
};

/* Of light from far away, which fog dims below its level top alone, as vxs_air_path_of has it. */
vec3 far_irradiance_of(gathering g, vec3 to_light)
{
    float top = vxs_frame.sizes.w, below = max(top - g.eye.y - g.metres * g.direction.y, 0.0), cosine = max(dot(g.normal, to_light), 0.0);
    if (!(top < VXS_AIR_EVERYWHERE) || below == 0.0) return vec3(cosine);
    return to_light.y > 0.0 ? exp(-g.medium.extinction * (below / to_light.y)) * cosine : vec3(0.0);
}

/* Of what shines from the lamp to a surface, how much reaches it, nothing between them. */
vec3 irradiance_of(gathering g, uint n, vec3 to_lamp)
{
    if (vxs_area.lamps[n].normal.w == vxs_area_far) return far_irradiance_of(g, -vxs_area.lamps[n].normal.xyz);
    float square = max(dot(to_lamp, to_lamp), 1e-20), metres = sqrt(square), radius = vxs_area.lamps[n].place.w;
    float cosine = max(dot(g.normal, to_lamp) / metres, 0.0);
    if (vxs_area.lamps[n].normal.w != 0.0) cosine *= max(-dot(vxs_area.lamps[n].normal.xyz, to_lamp) / metres, 0.0);
    return exp(-g.medium.extinction * metres) * (cosine / max(square, radius * radius));
}

/* How much of it does. About the way to the lamp what is before it is in the dark, and what is behind it lit. */
float lit_of(gathering g, vxs_grid_size size, uint n, vxs_epipolar space, vxs_epipolar_ray ray, vxs_grid_rows rows)
{
    float across = vxs_grid_before(space.alpha, ray.alpha, size.columns);
    float bits = vxs_grid_bits_before(space, size, ray, g.metres);
    if (vxs_area.lamps[n].eye.x > 1) return 1.0;
    if (space.away > 0.0 && ray.cosine > 0.0 && space.alpha.x == 0.0 && across < 1.0) return g.metres >= space.away ? 1.0 : 0.0;
    if (bits < 0.5 && space.phi.x == 0.0) return float(vxs_area.lamps[n].eye.x);
    return vxs_grid_lit(n * uint(vxs_grid_words(size)), size, vxs_grid_voxel(across + vxs_frame.knobs.y, size.columns), rows,
                        bits + vxs_frame.knobs.z);
}

void add_lamp(inout gathering g, uint n)
{
    vxs_air_light lamp;
    bool is_far        = vxs_area.lamps[n].normal.w == vxs_area_far;
    lamp.kind          = is_far ? VXS_LIGHT_KIND_DIRECTIONAL : VXS_LIGHT_KIND_POINT;
    lamp.place         = is_far ? -vxs_area.lamps[n].normal.xyz : vxs_area.lamps[n].place.xyz;
    lamp.axis          = vxs_area.lamps[n].normal.xyz;
    lamp.cos_inner     = 1.0;
    lamp.cos_outer     = 0.0;
    lamp.radius_metres = vxs_area.lamps[n].place.w;
    lamp.range_metres  = 0.0;
    vxs_air_path     path = vxs_area_path(lamp, vxs_area.lamps[n].normal.w == 1.0 ? 1 : 0, g.eye, g.direction, g.metres, vxs_frame.sizes.w);
    vxs_epipolar     space = vxs_area_space(n);
    vxs_grid_size    size = vxs_grid_size(vxs_area.lamps[n].size.x, vxs_area.lamps[n].size.y, vxs_area.lamps[n].size.z);
    vxs_epipolar_ray ray = vxs_epipolar_eye(space, g.direction);
    vxs_grid_rows    rows = vxs_grid_row_of(space, size, ray.theta);
    vec3             air;
#ifdef VXS_GRID_DIMS
    vxs_area_lamp_now  = n;
    vxs_area_direction = g.direction;
#endif
    if (vxs_frame.counts.z != 0u) rows = vxs_grid_rows_about(space, size, ray.theta);
    vxs_grid_airlight_of(n * uint(vxs_grid_words(size)), space, size, g.medium, path, ray, rows, g.metres, int(vxs_frame.knobs.x),
                         vxs_area.lamps[n].eye.x, air);
    g.air += vxs_area.lamps[n].colour.rgb * air;
    if (g.normal == vec3(0.0)) return;
    vec3 irradiance = irradiance_of(g, n, lamp.place - g.eye - g.metres * g.direction);
    if (irradiance == vec3(0.0)) return;
    irradiance *= lit_of(g, size, n, space, ray, rows);
#ifdef VXS_GRID_DIMS
    irradiance *= vxs_grid_left(g.metres);
#endif
    g.surface += vxs_area.lamps[n].colour.rgb * irradiance;
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), pixel = vxs_frame.counts.y == 2u ? 2 * at : at;
    if (any(greaterThanEqual(gl_GlobalInvocationID.xy, vxs_frame.map.xy))) return;
    bool      ninths = vxs_frame.counts.y == 1u;
    uint      first = ninths ? uint(at.x % 3 + 3 * (at.y % 3)) : 0u, step = ninths ? 9u : 1u;
    gathering g;
    g.eye       = vxs_frame.eye_far.xyz;
    g.direction = vxs_eye_ray(pixel, g.metres);
    g.normal    = texelFetch(vxs_normals, pixel, 0).xyz;
    g.medium    = vxs_frame_medium();
    g.air = g.surface = vec3(0.0);
    for (uint n = first; n < vxs_frame.counts.x; n += step) add_lamp(g, n);
    imageStore(gathered, ivec3(at, 0), vec4(g.air * float(step), g.metres));
    imageStore(gathered, ivec3(at, 1), vec4(g.surface * float(step), g.metres));
}
