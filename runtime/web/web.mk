# The npm package `vxs` (make web), its tests (make check-web), and the page of comparisons (make web-compare). Other parts: runtime.mk
# here, the command in baker/web/baker.mk. docs/web.md says what the package holds.
# SPDX-License-Identifier: MIT

W := build/web
P := $W/vxs
# libraries from npm that build and test: runtime/web/tools pins them
web.tools := $W/node_modules/.package-lock.json
# emcc finds acorn there
export NODE_PATH := $(abspath $W/node_modules)

web.goals    := web check-web check-web-fast web-compare
packages.web := emscripten brotli dpkg-dev $(if $(shell command -v node),,nodejs) $(if $(shell command -v npm),,npm) \
                $(if $(filter-out web,$(filter $(web.goals),$(MAKECMDGOALS))),chromium python3-jsonschema)

$(web.tools): runtime/web/tools/package.json runtime/web/tools/package-lock.json | packages
	@echo "  npm  $(@D)"
	$Q mkdir -p $W && cp $^ $W/ && cd $W && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error && touch node_modules/.package-lock.json

# what `npm publish` takes: only these files. Parts add theirs
web.files := $P/package.json $P/README.md $P/LICENSE.MIT $P/LICENSE.GPL-3.0

$P/package.json: runtime/web/package.json runtime/vxs.h
$P/README.md: docs/web.md
$P/LICENSE.%: LICENSE.%
	$Q mkdir -p $(@D) && cp $< $@
$P/package.json:
	$Q mkdir -p $(@D) && sed 's/@version@/$(version)/' $< >$@
# links to other pages of the project lead to nothing in a package: their texts stay
$P/README.md:
	$Q mkdir -p $(@D) && sed -E 's/!?\[([^]]*)\]\([^):]*\)/\1/g' $< >$@

-include runtime/web/runtime.mk runtime/web/three.mk runtime/web/view.mk baker/web/baker.mk

.PHONY: $(web.goals)
web: $(web.files)
	@cd $P && npm pack --pack-destination .. --loglevel=error >/dev/null && ls -l ../vxs-$(version).tgz | awk '{ print "wrote $W/vxs-$(version).tgz: " $$5 " bytes" }'
check-web: web $B/vxs
	@VXS=$(abspath $B/vxs) VXS_PACKAGE=$(abspath $P) $(python) tests/web/run $(if $(only),--only $(only))
# the runtime and vxs/three alone, without the command, the page and tests that draw for long
check-web-fast: $(web.runtime) $(three.files) $P/runtime/shaders.mjs $P/package.json $B/tests/web/answers $B/vxs $(web.tools)
	@VXS=$(abspath $B/vxs) VXS_PACKAGE=$(abspath $P) $(python) tests/web/run --fast
web-compare: web $B/vxs
	@VXS=$(abspath $B/vxs) VXS_PACKAGE=$(abspath $P) node tests/bench/web_compare.mjs -o $W/compare
