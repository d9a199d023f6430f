## Lights a level with its baked shadows: finds the lights by name, and turns materials into ones that look shadows up.
# SPDX-License-Identifier: MIT
class_name VxsShadows
extends Node

const Level = preload("vxs_level.gd")
const Materials = preload("vxs_material.gd")
const MAX_LIGHTS = 64 # a shader has a varying for four of them
const CLASSES = ["", "DirectionalLight3D", "SpotLight3D", "OmniLight3D"]

## What `vxs export` wrote, or a .vxs that was baked with --pack fast.
@export_file("*.vxs", "*.json") var file := ""
## The root of what was baked; without one the parent of this node. If it moves, call refresh().
@export var level: Node3D
## Texels of the filter, 1 to 17; odd unless it is smooth.
@export_range(1, 17) var filter_width := 9:
	set(value):
		filter_width = value
		refresh()
@export var filter_is_smooth := true:
	set(value):
		filter_is_smooth = value
		refresh()

var baked: Level
## Lights of the scene that have baked shadows, and their numbers in `baked`.
var lights: Array[Light3D] = []
var numbers := PackedInt32Array()

var _root: Node3D
var _converted := {} # material: its ShaderMaterial, or null
var _restore: Array[Callable] = []
var _is_stale := false


func _ready() -> void:
	if file:
		attach(level if level else get_parent() as Node3D)


## Light what is below `root` with the shadows of `file`, or of `from`. Returns whether lights were found.
func attach(root: Node3D, from: Level = null) -> bool:
	detach()
	baked = from if from else Level.open(file)
	if not baked or not root:
		return false
	if not root.global_basis.get_scale().is_equal_approx(Vector3.ONE):
		push_error("vxs: '%s' is scaled: bake it at the size in which it is shown" % root.name)
		return false
	_root = root
	_match()
	if lights.is_empty():
		push_error("vxs: %s: no light below '%s' has a name or the place of a baked one" % [file, root.name])
		return false
	for mesh in root.find_children("*", "GeometryInstance3D", true, false):
		shade(mesh)
		_set(mesh, "cast_shadow", GeometryInstance3D.SHADOW_CASTING_SETTING_OFF) # its shadow is baked
	refresh()
	return true


## Let a mesh receive the shadows of the level: for what moves, or came later.
func shade(mesh: GeometryInstance3D) -> void:
	if mesh.material_override is BaseMaterial3D:
		_set(mesh, "material_override", _shaded(mesh.material_override))
	elif mesh is MeshInstance3D and mesh.mesh:
		for n in mesh.mesh.get_surface_count():
			_set(mesh, "surface_material_override/%d" % n, _shaded(mesh.get_active_material(n)), mesh.get_surface_override_material(n))
	elif mesh is MultiMeshInstance3D and mesh.multimesh and mesh.multimesh.mesh and mesh.multimesh.mesh.get_surface_count():
		_set(mesh, "material_override", _shaded(mesh.multimesh.mesh.surface_get_material(0)))


## Constants again, after the level, a light or the filter changed.
func refresh() -> void:
	_is_stale = false
	if not _root:
		return
	var constants := PackedInt32Array()
	var places: Array[Vector4] = []
	for n in lights.size():
		var light := lights[n]
		var sun := light is DirectionalLight3D
		var at := light.global_basis.z.normalized() if sun else light.global_position
		constants.append_array(baked.constants_of(numbers[n], _root.global_transform.affine_inverse()))
		places.append(Vector4(at.x, at.y, at.z, 0 if sun else 1))
	for material: ShaderMaterial in _converted.values():
		if material:
			material.set_shader_parameter("vxs_words", baked.words)
			material.set_shader_parameter("vxs_constants", constants)
			material.set_shader_parameter("vxs_places", places)
			material.set_shader_parameter("vxs_width", filter_width)
			material.set_shader_parameter("vxs_is_smooth", filter_is_smooth)


## Undo attach() and shade().
func detach() -> void:
	_restore.reverse()
	for undo in _restore:
		undo.call()
	_restore.clear()
	_converted.clear()
	lights.clear()
	numbers.clear()
	_root = null


func _shaded(material: Material) -> Material:
	var is_ready: bool = material is ShaderMaterial and material.shader and "vxs.gdshaderinc" in material.shader.code
	if material and not material is BaseMaterial3D and not is_ready:
		return material
	if not _converted.has(material):
		_converted[material] = material if is_ready else Materials.convert(material if material else StandardMaterial3D.new(), lights.size())
		if not _is_stale:
			_is_stale = true
			refresh.call_deferred()
	return _converted[material] if _converted[material] else material


func _set(object: Object, property: String, value: Variant, before: Variant = object.get(property)) -> void:
	_restore.append(func(): if is_instance_valid(object): object.set(property, before))
	object.set(property, value)


# Pairs of a light and a baked one of its kind: those of one name before those of one place, of several the nearest.
func _match() -> void:
	var pairs := []
	for light: Light3D in _root.find_children("*", "Light3D", true, false):
		for n in baked.light_count():
			if light.is_class(CLASSES[baked.kind(n)]):
				var is_named := _is_named(light, baked.names[n])
				var apart := _distance(light, baked.place(n))
				if is_named or apart < 0.01:
					pairs.append([0 if is_named else 1, apart, light, n])
	pairs.sort_custom(func(a, b): return a[0] < b[0] or (a[0] == b[0] and a[1] < b[1]))
	for pair in pairs:
		if not pair[2] in lights and not pair[3] in numbers and lights.size() < MAX_LIGHTS:
			lights.append(pair[2])
			numbers.append(pair[3])


# vxs appends #2 to a second light of a name. Godot gives other signs to names of nodes, and numbers to equal ones.
func _is_named(light: Light3D, name: String) -> bool:
	var plain := name.get_slice("#", 0).validate_node_name()
	for node: Node in [light, light.get_parent()]:
		var found := str(node.name)
		if found == name or found == plain or (found.begins_with(plain) and found.trim_prefix(plain).lstrip("_").is_valid_int()):
			return true
	return false


func _distance(light: Light3D, place: Vector4) -> float:
	var in_file := _root.global_transform.affine_inverse()
	var there := Vector3(place.x, place.y, place.z)
	if place.w == 0:
		return (in_file.basis * light.global_basis.z).normalized().distance_to(there)
	return (in_file * light.global_position).distance_to(there)
