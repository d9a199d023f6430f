# Lets `load("res://level.vxs")` and exported properties take .vxs files.
# SPDX-License-Identifier: MIT
@tool
class_name VxsFormatLoader
extends ResourceFormatLoader

const Level = preload("vxs_level.gd")


func _get_recognized_extensions() -> PackedStringArray:
	return ["vxs"]


func _handles_type(type: StringName) -> bool:
	return type == &"Resource"


func _get_resource_type(path: String) -> String:
	return "Resource" if path.get_extension() == "vxs" else ""


func _load(path: String, _original_path: String, _use_sub_threads: bool, _cache_mode: int) -> Variant:
	var level = Level.open(path)
	return level if level else ERR_FILE_CORRUPT
