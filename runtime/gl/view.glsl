/* Points of the pixels of a vxs_view. Compiled behind the texts of vxs_gl_texts. */
uniform highp sampler2D vxs_depths;
uniform mat4 vxs_point_from_depth;
uniform vec4 vxs_sizes; /* width, height, empty depth, 0 */

/* The point of a pixel. Returns false outside the view, and for an empty pixel: some depths have no finite point. */
bool vxs_pixel_point(ivec2 pixel, out vec3 at)
{
    at = vec3(0.0);
    if (float(pixel.x) >= vxs_sizes.x || float(pixel.y) >= vxs_sizes.y) return false;
    float depth = texelFetch(vxs_depths, pixel, 0).r;
    vec4  point = vxs_point_from_depth * vec4((vec2(pixel) + 0.5) / vxs_sizes.xy, depth, 1.0);
    at = point.xyz / point.w;
    return depth != vxs_sizes.z && all(lessThan(abs(at), vec3(VXS_VIEW_METRES)));
}
