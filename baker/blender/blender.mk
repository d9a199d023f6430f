# The Blender add-on: make blender packs it, make install-blender installs it.
# SPDX-License-Identifier: GPL-3.0-or-later

BLENDER     ?= blender
,           := ,
blender.zip := build/blender/vxs_shadows-$(version).zip
blender.py  := $(sort $(wildcard baker/blender/*.py)) baker/blender/blender_manifest.toml LICENSE.GPL-3.0

# the same files give the same bytes: names in order, one date
define blender_pack
import sys, zipfile, pathlib
with zipfile.ZipFile(sys.argv[1], "w", zipfile.ZIP_DEFLATED) as out:
    for file in map(pathlib.Path, sorted(sys.argv[2:])):
        info = zipfile.ZipInfo("vxs_shadows/" + file.name, (1980, 1, 1, 0, 0, 0))
        info.external_attr, info.compress_type = 0o644 << 16, zipfile.ZIP_DEFLATED
        out.writestr(info, file.read_bytes())
endef
export blender_pack

$(blender.zip): $(blender.py) baker/blender/blender.mk
	@grep -q '^version = "$(version)"$$' baker/blender/blender_manifest.toml && grep -q '"version": ($(subst .,$(,) ,$(version)))' baker/blender/__init__.py \
	    || { echo "baker/blender: its version is not $(version), as in runtime/vxs.h"; exit 1; }
	$Q mkdir -p $(@D) && $(python) -c "$$(printenv blender_pack)" $@ $(blender.py)

.PHONY: blender install-blender
blender: $(blender.zip)
	@ls -l $< | awk '{ print "wrote $<: " $$5 " bytes" }'

# add-ons are extensions from Blender 4.2 on
install-blender: $(blender.zip)
	$Q if $(BLENDER) --version | awk 'NR == 1 { split($$2, v, "."); exit v[1] * 100 + v[2] < 402 }'; then \
	    $(BLENDER) --command extension install-file --repo user_default --enable $<; \
	else \
	    $(BLENDER) -b --python-exit-code 1 --python-expr 'import bpy; bpy.ops.preferences.addon_install(filepath="$(abspath $<)"); bpy.ops.preferences.addon_enable(module="vxs_shadows"); bpy.ops.wm.save_userpref()'; \
	fi
