# Materials of Godot beside what vxs_material.gd makes of them, in lights that have no baked shadows: a picture of each.
# SPDX-License-Identifier: GPL-3.0-or-later
extends Node3D

const Materials = preload("res://addons/vxs/vxs_material.gd")


func _ready() -> void:
	var camera := Camera3D.new()
	add_child(camera)
	camera.look_at_from_position(Vector3(0, 0, 3), Vector3.ZERO)
	for made: Light3D in [DirectionalLight3D.new(), OmniLight3D.new(), SpotLight3D.new()]:
		add_child(made)
		made.look_at_from_position(Vector3(2, 3, 4) if made is SpotLight3D else Vector3(-3, 1, 4), Vector3.ZERO)
		made.light_energy = 0.5
		if not made is DirectionalLight3D:
			made.set("omni_range" if made is OmniLight3D else "spot_range", 12)
	var mesh := _sphere()
	var balls: Array[MeshInstance3D] = []
	for n in _materials().size():
		var ball := MeshInstance3D.new()
		ball.mesh = mesh
		ball.position = Vector3(1.4 * (n % 4) - 2.1, 0.8 - 1.6 * (n / 4), 0)
		add_child(ball)
		balls.append(ball)
	for way in ["standard", "converted"]:
		for n in balls.size():
			var material := _materials()[n]
			var converted := Materials.convert(material, 1)
			balls[n].material_override = converted if way == "converted" and converted else material
		print("VXS unshaded = %s" % (Materials.convert(_materials()[7], 1) == null))
		for n in 3:
			await RenderingServer.frame_post_draw
		var image := get_viewport().get_texture().get_image()
		image.convert(Image.FORMAT_RGB8)
		print("VXS %s %s" % [way, Marshalls.raw_to_base64(image.get_data())])
	print("VXS END -")


# With colours of vertices.
func _sphere() -> ArrayMesh:
	var sphere := SphereMesh.new()
	sphere.radius = 0.65
	sphere.height = 1.3
	var arrays := sphere.get_mesh_arrays()
	var colors := PackedColorArray()
	for point: Vector3 in arrays[Mesh.ARRAY_VERTEX]:
		colors.append(Color(0.5 + 0.7 * point.x, 0.6, 0.5 + 0.7 * point.y))
	arrays[Mesh.ARRAY_COLOR] = colors
	var mesh := ArrayMesh.new()
	mesh.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, arrays)
	return mesh


func _texture(of: Callable) -> ImageTexture:
	var image := Image.create_empty(32, 32, false, Image.FORMAT_RGBA8)
	for y in 32:
		for x in 32:
			image.set_pixel(x, y, of.call(x / 31.0, y / 31.0))
	return ImageTexture.create_from_image(image)


func _materials() -> Array[StandardMaterial3D]:
	var all: Array[StandardMaterial3D] = []
	for n in 8:
		all.append(StandardMaterial3D.new())
		all[n].roughness = 0.4
	all[0].albedo_color = Color(0.8, 0.3, 0.2)
	all[1].metallic = 1
	all[1].metallic_texture = _texture(func(x, y): return Color(1, x, y))
	all[1].metallic_texture_channel = BaseMaterial3D.TEXTURE_CHANNEL_BLUE
	all[1].roughness_texture = all[1].metallic_texture
	all[1].roughness_texture_channel = BaseMaterial3D.TEXTURE_CHANNEL_GREEN
	all[2].normal_enabled = true
	all[2].normal_texture = _texture(func(x, y): return Color(0.5 + 0.2 * sin(12 * x), 0.5 + 0.2 * cos(9 * y), 0.9))
	all[2].normal_scale = 0.7
	all[3].albedo_texture = _texture(func(x, y): return Color(x, y, 0.5, 1 if int(8 * x + 8 * y) % 2 else 0))
	all[3].transparency = BaseMaterial3D.TRANSPARENCY_ALPHA_SCISSOR
	all[3].cull_mode = BaseMaterial3D.CULL_DISABLED
	all[3].uv1_scale = Vector3(2, 1, 1)
	all[4].emission_enabled = true
	all[4].emission = Color(0.2, 0.1, 0)
	all[4].emission_texture = _texture(func(x, y): return Color(0.1 * x, 0, 0.4 * y))
	all[5].vertex_color_use_as_albedo = true
	all[6].albedo_color = Color(0.2, 0.9, 0.3, 0.5)
	all[6].transparency = BaseMaterial3D.TRANSPARENCY_ALPHA
	all[7].shading_mode = BaseMaterial3D.SHADING_MODE_UNSHADED
	return all
