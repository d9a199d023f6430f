# Tests of the add-on for Blender. They install nothing, and skip what has no Blender: blender of PATH, and each Python with the module
# bpy that BPY names, separated by colons.
# SPDX-License-Identifier: GPL-3.0-or-later

.PHONY: check-blender
check-blender: $B/vxs $(blender.zip)
	@VXS=$(abspath $B/vxs) ADDON=$(abspath $(blender.zip)) BLENDER="$(BLENDER)" $(python) tests/blender/run $(if $(only),--only $(only))

.PHONY: bench-blender
bench-blender: $B/vxs $(blender.zip)
	@VXS=$(abspath $B/vxs) ADDON=$(abspath $(blender.zip)) BLENDER="$(BLENDER)" $(python) tests/blender/speed.py

# vxs beside lightmaps of Cycles: docs/blender.md. only=city,room: levels by their beginnings; quick=1: coarse, to test the program
.PHONY: compare-cycles
compare-cycles: $B/vxs $(blender.zip)
	$Q $(python) tests/blender/beside_cycles.py --blender "$(BLENDER)" --vxs $B/vxs --addon $(blender.zip) --out build/blender/cycles.json \
	    --only "$(only)" $(if $(quick),--quick)
