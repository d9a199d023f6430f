# A dock that runs `vxs bake` on a .glb of the project.
# SPDX-License-Identifier: MIT
@tool
extends VBoxContainer

var _command := _line("Command", "vxs")
var _scene := _line("Scene (.glb)", "res://level.glb")
var _options := _line("Options", "--resolution 4096")
var _button := Button.new()
var _report := Label.new()
var _running := -1


func _init() -> void:
	name = "vxs"
	_button.text = "Bake"
	_button.pressed.connect(_bake)
	_report.autowrap_mode = TextServer.AUTOWRAP_WORD_SMART
	add_child(_button)
	add_child(_report)
	set_process(false)


func _line(title: String, text: String) -> LineEdit:
	var label := Label.new()
	label.text = title
	add_child(label)
	var edit := LineEdit.new()
	edit.text = text
	add_child(edit)
	return edit


func _bake() -> void:
	var scene := ProjectSettings.globalize_path(_scene.text)
	var out := scene.get_basename() + ".vxs"
	var arguments := PackedStringArray(["bake", scene, "-o", out, "--pack", "fast", "--quiet"])
	arguments.append_array(_options.text.split(" ", false))
	_running = OS.create_process(_command.text, arguments)
	_report.text = "baking ..." if _running > 0 else "'%s' cannot be started" % _command.text
	_button.disabled = _running > 0
	set_process(_running > 0)


func _process(_delta: float) -> void:
	if OS.is_process_running(_running):
		return
	set_process(false)
	_button.disabled = false
	var status := OS.get_process_exit_code(_running)
	_report.text = "done" if status == 0 else "vxs bake ended with status %d: run it in a terminal to see why" % status
	EditorInterface.get_resource_filesystem().scan()
