/* Before march.glsl: its light is a face, whose normal is the light's axis. */
vxs_air_path face_path(vec3 direction, float metres)
{
    return vxs_area_path(vxs_frame_light(), 1, vxs_frame.eye_far.xyz, direction, metres, vxs_frame.sizes.w);
}
#define vxs_eye_path face_path
