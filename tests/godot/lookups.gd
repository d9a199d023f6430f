# Answers of vxs.gdshaderinc to rows of a texture, as bits of floats: cases.json says which.
# SPDX-License-Identifier: GPL-3.0-or-later
extends Node3D

const Level = preload("res://addons/vxs/vxs_level.gd")
const COUNT = 1024
const CODE = """shader_type canvas_item;
render_mode blend_disabled;
#define VXS_LIGHTS 1
#include "res://addons/vxs/vxs.gdshaderinc"
uniform sampler2D rows : filter_nearest;
uniform bool in_world;

void fragment()
{
    int n = int(floor(UV.x * 64.0)) + 64 * int(floor(UV.y * 16.0));
    vec4 first = texelFetch(rows, ivec2(0, n), 0), second = texelFetch(rows, ivec2(1, n), 0);
    vxs_light_constants light = vxs_light(0);
    vxs_filter pcf = vxs_box(vxs_width);
    if (vxs_is_smooth) pcf.is_smooth = 1;
    float lit = -1.0;
    if (in_world) lit = vxs_lit(light.first_word, light, first.xyz, second.xyz, pcf);
    else {
        vxs_place place;
        place.map = int(second.x);
        place.voxel = ivec3(first.xyz);
        place.across = uint(second.y);
        place.down = uint(second.z);
        lit = vxs_lit_at_place(light.first_word, light, place, pcf);
    }
    uint bits = floatBitsToUint(lit);
    COLOR = vec4(uvec4(bits, bits >> 8u, bits >> 16u, bits >> 24u) & uvec4(255u)) / 255.0;
}
"""


func _ready() -> void:
	var view := SubViewport.new()
	view.size = Vector2i(64, 16)
	view.transparent_bg = true
	view.render_target_update_mode = SubViewport.UPDATE_ALWAYS
	var quad := ColorRect.new()
	quad.size = view.size
	var material := ShaderMaterial.new()
	material.shader = Shader.new()
	material.shader.code = CODE
	quad.material = material
	view.add_child(quad)
	add_child(view)
	var level := Level.open("res://export")
	material.set_shader_parameter("vxs_words", level.words)
	for case in JSON.parse_string(FileAccess.get_file_as_string("res://cases.json")):
		var image := Image.create_from_data(2, COUNT, false, Image.FORMAT_RGBAF, FileAccess.get_file_as_bytes("res://" + case.rows))
		material.set_shader_parameter("rows", ImageTexture.create_from_image(image))
		material.set_shader_parameter("vxs_constants", level.constants_of(int(case.light)))
		material.set_shader_parameter("vxs_width", int(abs(case.width)))
		material.set_shader_parameter("vxs_is_smooth", case.width < 0)
		material.set_shader_parameter("in_world", case.in_world)
		for n in 2:
			await RenderingServer.frame_post_draw
		print("VXS %s %s" % [case.rows, Marshalls.raw_to_base64(view.get_texture().get_image().get_data())])
	print("VXS END -")
