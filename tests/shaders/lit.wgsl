@group(0) @binding(0) var<storage, read> words: array<u32>;
@group(0) @binding(1) var<uniform> light: vxs_light_constants;

fn vxs_word_at(at: u32) -> u32 { return words[at]; }

@fragment
fn main(@location(0) position_ws: vec3f, @location(1) normal_ws: vec3f) -> @location(0) f32
{
    return vxs_lit(light.first_word, light, position_ws, normal_ws, vxs_box(9));
}
