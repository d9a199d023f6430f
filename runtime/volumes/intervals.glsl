/* A ray for each pixel, and where the asset says exactly that it is lit: no steps, but a closed form of each lit part. */
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = VXS_AT_IMAGE) uniform restrict image2D airlight;

void main()
{
    ivec2 pixel;
    if (!vxs_pixel(pixel)) return;
    float        metres;
    vec3         direction = vxs_eye_ray(pixel, metres), sum = vec3(0.0), air;
    vxs_medium   medium = vxs_frame_medium();
    vxs_air_path path = vxs_eye_path(direction, metres);
    /* behind VXS_AIR_DEPTH_MAX units of optical depth nothing is seen */
    float        thin = min(medium.extinction.x, min(medium.extinction.y, medium.extinction.z));
    if (thin * (path.end - path.begin) > VXS_AIR_DEPTH_MAX) path.end = path.begin + VXS_AIR_DEPTH_MAX / thin;
    if (!(path.end > path.begin)) return;
    vxs_walk     w = vxs_walk_of(vxs_frame.light, vxs_frame.eye_far.xyz, direction, path.begin, path.end);
    vxs_span     span;
    if (path.kind == VXS_LIGHT_KIND_DIRECTIONAL) w.outside = VXS_SPAN_LIT; /* where its map ends, the sun shines on */
    while (vxs_walk_next_lit(vxs_frame.light.dag, vxs_frame.light, w, span) != 0) {
        vxs_air_lit(medium, path, span.begin, span.end, air);
        sum += air;
    }
    imageStore(airlight, pixel, imageLoad(airlight, pixel) + vec4(sum * vxs_frame.colour.rgb, 0.0));
}
