# `vxs/three`, `vxs/three/webgpu`, `vxs/gltf-transform` and the texts of shaders: build/web/vxs/three, build/web/vxs/runtime/shaders.mjs.
# Included by web.mk.
# SPDX-License-Identifier: MIT

three.files := $(patsubst runtime/web/three/%,$P/three/%,$(wildcard runtime/web/three/*.mjs runtime/web/three/*.d.ts runtime/web/three/*.json))
web.files   += $(three.files) $P/runtime/shaders.mjs

$(three.files): $P/three/%: runtime/web/three/%
	$Q mkdir -p $(@D) && cp $< $@

# a string for each header: vxs_lookup.h is `vxs_lookup`
shaders.texts := $(addprefix formats/,vxs_lookup.h vxs_lookup_blocks.h vxs_space.h vxs_depths.h vxs_intervals.h vxs_smoke.h) \
                 runtime/gl/tables.glsl runtime/web/three/fog.glsl \
                 $(addprefix runtime/volumes/,vxs_air_light.h vxs_air_ray.h vxs_air.h vxs_air_path.h)
$P/runtime/shaders.mjs: $(shaders.texts) runtime/web/shaders.py runtime/web/three.mk
	@echo "  text $@"
	$Q mkdir -p $(@D) && $(python) runtime/web/shaders.py $(shaders.texts) >$@

check-web web-compare: $(web.tools)
