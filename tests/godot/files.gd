# What VxsLevel reads of exports and files: cases.json says which. Then a file with damage in it, for which it must return an error or a
# level, without an error of a script.
# SPDX-License-Identifier: GPL-3.0-or-later
extends Node3D

const Level = preload("res://addons/vxs/vxs_level.gd")
const File = preload("res://addons/vxs/vxs_file.gd")
const OWN = """shader_type spatial;
#define VXS_LIGHTS 2
#include "res://addons/vxs/vxs.gdshaderinc"
void fragment() { VXS_LOOK_UP(VERTEX, INV_VIEW_MATRIX) ALBEDO = vec3(0.5); }
void light() { float lit = ATTENUATION; VXS_SHADE(lit, LIGHT, LIGHT_IS_DIRECTIONAL, INV_VIEW_MATRIX) DIFFUSE_LIGHT += lit * LIGHT_COLOR; }
"""


func _ready() -> void:
	var cases: Dictionary = JSON.parse_string(FileAccess.get_file_as_string("res://cases.json"))
	for path: String in cases.read:
		var begin := Time.get_ticks_msec()
		var level := Level.open("res://" + path)
		print("VXS %s.ms = %d" % [path, Time.get_ticks_msec() - begin])
		print("VXS %s.names = %s" % [path, "|".join(level.names)])
		print("VXS %s.constants %s" % [path, Marshalls.raw_to_base64(level.constants)])
		print("VXS %s.words %s" % [path, Marshalls.raw_to_base64(level.words.get_image().get_data())])
	print("VXS loaded = %s" % (load("res://" + cases.read[-1]) is Level))
	for path: String in cases.refused:
		print("VXS %s.opened = %s" % [path, Level.open("res://" + path) != null])
	var dock := GDScript.new() # it parses, and its button is there; what it calls of the editor is not
	var text := FileAccess.get_file_as_string("res://addons/vxs/dock.gd")
	dock.source_code = text.replace("EditorInterface.get_resource_filesystem().scan()", "pass")
	print("VXS dock = %s" % (dock.reload() == OK and dock.new().find_children("*", "Button", true, false).size() == 1))
	await _pair(Level.open("res://room"))
	var whole := FileAccess.get_file_as_bytes("res://" + cases.damaged)
	var refused := 0
	for n in int(cases.times):
		var bytes := whole.duplicate()
		if n % 4 == 0:
			bytes.resize(whole.size() * n / int(cases.times))
		else:
			for k in n % 4:
				bytes[(n * 7919 + k * 104729) % (256 if n % 2 else bytes.size())] ^= 1 << n % 8
		refused += 1 if File.new().read(bytes) else 0
	print("VXS refused = %d" % refused)
	print("VXS END -")


# Of the room's lights, the point light has a namesake elsewhere and an unnamed one at its place, the spot only the latter.
func _pair(room: Level) -> void:
	var root := Node3D.new()
	add_child(root)
	var far := Vector4(9, 9, 9, 1)
	for entry in [[OmniLight3D.new(), "x", room.place(0)], [OmniLight3D.new(), "lamp3", far], [SpotLight3D.new(), "y", room.place(1)],
			[SpotLight3D.new(), "z", far]]:
		root.add_child(entry[0])
		entry[0].name = entry[1]
		entry[0].position = Vector3(entry[2].x, entry[2].y, entry[2].z)
	var ball := MeshInstance3D.new()
	ball.mesh = SphereMesh.new()
	var own := ShaderMaterial.new()
	own.shader = Shader.new()
	own.shader.code = OWN
	ball.mesh.material = own
	root.add_child(ball)
	var shadows := VxsShadows.new()
	add_child(shadows)
	shadows.attach(root, room)
	for n in shadows.lights.size():
		print("VXS pair.%d = %s %s" % [n, shadows.lights[n].name, room.names[shadows.numbers[n]]])
	print("VXS own = %s" % (ball.get_active_material(0) == own and own.get_shader_parameter("vxs_words") == room.words))
	await RenderingServer.frame_post_draw
	root.scale = Vector3.ONE * 2
	print("VXS scaled = %s" % shadows.attach(root, room))
