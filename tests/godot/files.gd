# What VxsLevel reads of exports and files: cases.json says which. Then a file with damage in it, for which it must return an error or a
# level, without an error of a script.
# SPDX-License-Identifier: GPL-3.0-or-later
extends Node3D

const Level = preload("res://addons/vxs/vxs_level.gd")
const File = preload("res://addons/vxs/vxs_file.gd")


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
