# `vxs/three`, `vxs/three/webgpu`, `vxs/gltf-transform` and the texts of shaders: build/web/vxs/three, build/web/vxs/runtime/shaders.mjs.
# Included by web.mk.
# SPDX-License-Identifier: MIT

three.files := $(patsubst runtime/web/three/%,$P/three/%,$(wildcard runtime/web/three/*.mjs runtime/web/three/*.d.ts runtime/web/three/*.json))
web.files   += $(three.files) $P/runtime/shaders.mjs

$(three.files): $P/three/%: runtime/web/three/%
	$Q mkdir -p $(@D) && cp $< $@

# a string for each header: vxs_lookup.h is `vxs_lookup`
shaders.texts := vxs_lookup vxs_lookup_blocks vxs_space vxs_depths vxs_intervals vxs_smoke
$P/runtime/shaders.mjs: $(shaders.texts:%=formats/%.h) runtime/web/shaders.py
	@echo "  text $@"
	$Q mkdir -p $(@D) && $(python) runtime/web/shaders.py $(shaders.texts:%=formats/%.h) >$@

check-web web-compare: $(web.tools)
