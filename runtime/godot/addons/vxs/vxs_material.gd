# A StandardMaterial3D as a ShaderMaterial that is lit by baked shadows times live ones. Not taken over: clearcoat, rim, anisotropy,
# backlight, subsurface scattering, height, detail, refraction, second UVs, triplanar mapping, billboards; diffuse and specular modes
# other than Burley and GGX.
# SPDX-License-Identifier: MIT
extends Object

const FOLDER = "res://addons/vxs/"
const NUMBERS = ["albedo", "uv1_scale", "uv1_offset", "metallic", "metallic_specular", "roughness", "ao_light_affect", "normal_scale",
	"emission", "emission_energy_multiplier", "alpha_scissor_threshold"]
const FILTERS = ["filter_nearest", "filter_linear", "filter_nearest_mipmap", "filter_linear_mipmap", "filter_nearest_mipmap_anisotropic",
	"filter_linear_mipmap_anisotropic"]
const CULLING = ["cull_back", "cull_front", "cull_disabled"]

static var _shaders := {}


## The shader text of a material, for a number of baked lights.
static func code_of(material: BaseMaterial3D, light_count: int) -> String:
	var modes := PackedStringArray([CULLING[material.cull_mode]])
	var defines := PackedStringArray(["VXS_LIGHTS %d" % light_count,
			"SAMPLING %s, %s" % [FILTERS[material.texture_filter], "repeat_enable" if material.texture_repeat else "repeat_disable"],
			"GLOW(a, b) (a %s b)" % ("+" if material.emission_operator == BaseMaterial3D.EMISSION_OP_ADD else "*")])
	for name in _textures_of(material):
		defines.append("HAS_" + name.to_upper())
	if material.vertex_color_use_as_albedo:
		defines.append("HAS_VERTEX_COLOR")
	match material.transparency:
		BaseMaterial3D.TRANSPARENCY_DISABLED:
			pass
		BaseMaterial3D.TRANSPARENCY_ALPHA_SCISSOR:
			defines.append("HAS_SCISSOR")
		BaseMaterial3D.TRANSPARENCY_ALPHA_DEPTH_PRE_PASS:
			defines.append("HAS_ALPHA")
			modes.append("depth_prepass_alpha")
		_:
			defines.append("HAS_ALPHA")
	return "shader_type spatial;\nrender_mode %s;\n%s#include \"%svxs.gdshaderinc\"\n#include \"%svxs_standard.gdshaderinc\"\n" % [
			", ".join(modes), "".join(Array(defines).map(func(line): return "#define %s\n" % line)), FOLDER, FOLDER]


## A new material; null for one that is not lit.
static func convert(material: BaseMaterial3D, light_count: int) -> ShaderMaterial:
	if material.shading_mode == BaseMaterial3D.SHADING_MODE_UNSHADED:
		return null
	var code := code_of(material, light_count)
	if not _shaders.has(code):
		_shaders[code] = Shader.new()
		_shaders[code].code = code
	var made := ShaderMaterial.new()
	made.resource_name = material.resource_name
	made.render_priority = material.render_priority
	made.next_pass = material.next_pass
	made.shader = _shaders[code]
	for name in NUMBERS:
		var property: String = "albedo_color" if name == "albedo" else name
		made.set_shader_parameter(name, material.get(property))
	if not material.emission_enabled:
		made.set_shader_parameter("emission", Color.BLACK)
	var textures := _textures_of(material)
	for name in textures:
		made.set_shader_parameter(name + "_texture", textures[name])
	for name in ["metallic", "roughness", "ao"]:
		made.set_shader_parameter(name + "_channel", _channel(material.get(name + "_texture_channel")))
	return made


static func _textures_of(material: BaseMaterial3D) -> Dictionary:
	var found := {"albedo": material.albedo_texture}
	for name in ["metallic", "roughness"]:
		found[name] = material.get(name + "_texture")
	for name in ["normal", "emission", "ao"]:
		found[name] = material.get(name + "_texture") if material.get(name + "_enabled") else null
	for name in found.keys():
		if found[name] == null:
			found.erase(name)
	return found


static func _channel(number: int) -> Vector4:
	if number == BaseMaterial3D.TEXTURE_CHANNEL_GRAYSCALE:
		return Vector4(1, 1, 1, 0) / 3.0
	var channel := Vector4.ZERO
	channel[number] = 1
	return channel
