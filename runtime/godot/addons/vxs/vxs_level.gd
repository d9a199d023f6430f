## The baked shadows of a level: what `vxs export` writes (its folder, or shadows.json in it), or a .vxs file that was baked with
## --pack fast.
# SPDX-License-Identifier: MIT
class_name VxsLevel
extends Resource

const WIDE = 2048 # texels of the texture of words, as in vxs.gdshaderinc
const CONSTANTS = 96 # bytes of vxs_light_constants
const HIGH = 16384
const File = preload("vxs_file.gd")
enum { DIRECTIONAL = 1, SPOT, POINT }

## Names of the lights, in the order of the file.
@export var names := PackedStringArray()
## Of each light vxs_light_constants (vxs.h).
@export var constants := PackedByteArray()
## Words of all lights: a word is a texel.
@export var words: ImageTexture


## Open a folder, shadows.json or a .vxs. null, and one line on the console, when it cannot be read.
static func open(path: String) -> VxsLevel:
	var level := new()
	var error := level._read_file(path) if path.get_extension() == "vxs" else level._read_export(path)
	if error:
		push_error("vxs: %s: %s" % [path, error])
		return null
	return level


func light_count() -> int:
	return constants.size() / CONSTANTS


func kind(n: int) -> int:
	return constants.decode_u32(CONSTANTS * n + 68)


## (Its position, 1) of a spot or point light; (the direction to it, 0) of a sun.
func place(n: int) -> Vector4:
	var row := func(k: int) -> Vector3: return Vector3(_float(n, 4 * k), _float(n, 4 * k + 1), _float(n, 4 * k + 2))
	var sun := kind(n) == DIRECTIONAL
	var at: Vector3 = -row.call(2).normalized()
	if not sun:
		at = -(row.call(0) * _float(n, 3) + row.call(1) * _float(n, 7) + row.call(2) * _float(n, 11))
	return Vector4(at.x, at.y, at.z, 0.0 if sun else 1.0)


## The 24 words of a light's constants, for a level that stands elsewhere: file_from_world takes the world to where it was baked.
func constants_of(n: int, file_from_world := Transform3D.IDENTITY) -> PackedInt32Array:
	var bytes := constants.slice(CONSTANTS * n, CONSTANTS * (n + 1))
	if not file_from_world.is_equal_approx(Transform3D.IDENTITY):
		for row in 3:
			for column in 4:
				var by: Vector3 = file_from_world.origin if column == 3 else file_from_world.basis[column]
				var sum := _float(n, 4 * row + 3) if column == 3 else 0.0
				for k in 3:
					sum += _float(n, 4 * row + k) * by[k]
				bytes.encode_float(16 * row + 4 * column, sum)
	return bytes.to_int32_array()


func _float(n: int, word: int) -> float:
	return constants.decode_float(CONSTANTS * n + 4 * word)


func _read_export(path: String) -> String:
	var folder := path.get_base_dir() if path.get_extension() == "json" else path
	var text := FileAccess.get_file_as_string(folder.path_join("shadows.json"))
	if text.is_empty():
		return "no shadows.json of vxs export"
	var parser := JSON.new()
	if parser.parse(text) != OK or not parser.data is Dictionary:
		return "shadows.json is not JSON"
	var root: Dictionary = parser.data
	if not root.get("axes") in ["gltf", "godot"] or not root.get("lights") is Array:
		return "shadows.json has lights for '%s': export with --axes godot" % root.get("axes")
	for light in root.lights:
		names.append(str(light.get("name")) if light is Dictionary else "")
	constants = FileAccess.get_file_as_bytes(folder.path_join("lights.bin"))
	var bytes := FileAccess.get_file_as_bytes(folder.path_join("words.bin"))
	if bytes.is_empty() or not root.get("word_count") is float or bytes.size() != 4 * int(root.word_count):
		return "words.bin is not that of shadows.json"
	return _take(bytes)


func _read_file(path: String) -> String:
	var file := File.new()
	var error := file.read(FileAccess.get_file_as_bytes(path))
	names = file.names
	constants = file.constants
	return error if error else _take(file.words)


# Check the constants, and make the texture.
func _take(bytes: PackedByteArray) -> String:
	var count := bytes.size() / 4
	if names.is_empty() or constants.size() != CONSTANTS * names.size():
		return "lights.bin is not that of shadows.json"
	for n in light_count():
		var levels := constants.decode_u32(CONSTANTS * n + 76)
		if constants.decode_u32(CONSTANTS * n + 84) != 2:
			return "light '%s' is a DAG, which this add-on does not read: bake without --coding dag" % names[n]
		if kind(n) < DIRECTIONAL or kind(n) > POINT or levels < 3 or levels > 18 or constants.decode_u32(CONSTANTS * n + 80) >= count:
			return "light '%s' has constants that cannot be" % names[n]
	var high := (count + WIDE - 1) / WIDE
	if high > HIGH:
		return "%d words do not fit into a texture: export fewer lights" % count
	bytes.resize(4 * WIDE * high)
	words = ImageTexture.create_from_image(Image.create_from_data(WIDE, high, false, Image.FORMAT_RGBA8, bytes))
	return ""
