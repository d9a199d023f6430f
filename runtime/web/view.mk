# The page of `vxs view`: build/web/view.html, one file, into which the command writes a level. Included by web.mk.
# SPDX-License-Identifier: MIT

view.files := $(wildcard runtime/web/view/*)
web.files  += $P/view.html

$W/view.html: $(view.files) $(web.runtime) $(three.files) $P/runtime/shaders.mjs $(web.tools)
	@echo "  page $@"
	$Q VXS_PACKAGE=$(abspath $P) node runtime/web/view/bundle.mjs $@
$P/view.html: $W/view.html
	$Q cp $< $@
