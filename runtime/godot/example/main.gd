# A level that is loaded at run time: level.glb and level.vxs beside this script.
# SPDX-License-Identifier: MIT
extends Node3D

@export_file("*.glb") var scene := "res://level.glb"
@export_file("*.vxs", "*.json") var shadows := "res://level.vxs"


func _ready() -> void:
	var document := GLTFDocument.new()
	var state := GLTFState.new()
	if document.append_from_file(scene, state) != OK:
		push_error("%s cannot be read" % scene)
		return
	var level := document.generate_scene(state)
	add_child(level)
	var baked := VxsShadows.new()
	baked.file = shadows
	baked.level = level
	add_child(baked)
