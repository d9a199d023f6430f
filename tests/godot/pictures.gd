# Pictures of a level, by each of its lights alone: as Godot draws it without shadows, with baked ones, and, of `mover`, with the live
# shadow of a box in addition. case.json: eye, target, fov, sun (a direction, for a level whose sun only the bake was given), energy of
# lights, width, smooth; at and turn (radians), where the level stands instead of where it was baked.
# SPDX-License-Identifier: GPL-3.0-or-later
extends "res://example.gd"

var case: Dictionary = JSON.parse_string(FileAccess.get_file_as_string("res://case.json"))


func _ready() -> void:
	child_entered_tree.connect(_complete)
	super()
	var shadows_node: VxsShadows = find_children("*", "VxsShadows", true, false)[0]
	shadows_node.filter_width = int(case.width)
	shadows_node.filter_is_smooth = case.smooth
	var camera := Camera3D.new()
	camera.fov = case.fov
	camera.far = 2000
	add_child(camera)
	var at := shadows_node.level.transform
	camera.look_at_from_position(at * _vector(case.eye), at * _vector(case.target))
	var lights := shadows_node.lights.duplicate()
	var pairs := PackedStringArray()
	for n in lights.size():
		pairs.append("%s=%s" % [lights[n].name, shadows_node.baked.names[shadows_node.numbers[n]]])
	print("VXS lights = %s" % "|".join(pairs))
	for light: Light3D in lights:
		light.light_energy = case.energy[light.name]
	for light: Light3D in lights:
		for other: Light3D in lights:
			other.visible = other == light
		shadows_node.detach()
		await _shoot(light.name + ".bare")
		shadows_node.attach(shadows_node.level)
		await _shoot(light.name + ".baked")
	if case.has("mover"):
		var box := MeshInstance3D.new()
		box.mesh = BoxMesh.new()
		box.mesh.size = Vector3.ONE * case.size
		add_child(box)
		box.position = _vector(case.mover)
		box.cast_shadow = GeometryInstance3D.SHADOW_CASTING_SETTING_SHADOWS_ONLY
		lights[-1].shadow_enabled = true
		lights[-1].directional_shadow_max_distance = 600
		await _shoot("mover")
	print("VXS END -")


# A level that has come: Godot has no normals for a mesh without any, which glTF says is flat.
func _complete(level: Node) -> void:
	if level is VxsShadows or level is Camera3D:
		return
	for node: MeshInstance3D in level.find_children("*", "MeshInstance3D", true, false):
		var flat := ArrayMesh.new()
		for n in node.mesh.get_surface_count():
			var arrays: Array = node.mesh.surface_get_arrays(n)
			var points := PackedVector3Array()
			var normals := PackedVector3Array()
			for index: int in arrays[Mesh.ARRAY_INDEX]:
				points.append(arrays[Mesh.ARRAY_VERTEX][index])
			for at in range(0, points.size(), 3):
				var normal := Plane(points[at], points[at + 1], points[at + 2]).normal
				normals.append_array([normal, normal, normal])
			var made := []
			made.resize(Mesh.ARRAY_MAX)
			made[Mesh.ARRAY_VERTEX] = points
			made[Mesh.ARRAY_NORMAL] = normals
			flat.add_surface_from_arrays(Mesh.PRIMITIVE_TRIANGLES, made)
			flat.surface_set_material(n, node.mesh.surface_get_material(n))
		node.mesh = flat
	if case.has("sun"):
		var sun := DirectionalLight3D.new()
		level.add_child(sun)
		sun.name = "sun"
		sun.look_at_from_position(Vector3.ZERO, _vector(case.sun))
	if case.has("at"):
		level.transform = Transform3D(Basis(Vector3.UP, case.turn), _vector(case.at))


func _shoot(called: String) -> void:
	for n in 3:
		await RenderingServer.frame_post_draw
	var image := get_viewport().get_texture().get_image()
	image.convert(Image.FORMAT_RGB8)
	print("VXS %s %s" % [called, Marshalls.raw_to_base64(image.get_data())])


func _vector(numbers: Array) -> Vector3:
	return Vector3(numbers[0], numbers[1], numbers[2])
