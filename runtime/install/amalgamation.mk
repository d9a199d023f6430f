# The runtime in two files, for programs that compile it themselves: build/amalgamation; and all sources as one archive: make dist.
# SPDX-License-Identifier: MIT
#
#   vxs.h, vxs.c, LICENSE    of this project
#   zstddeclib.c, COPYING.zstd    the decoder of zstd, joined by its own script from Debian's source package; packages=skip leaves it out

A := build/amalgamation
packages.amalgamation := python3 dpkg-dev

.PHONY: dist
dist:
	@mkdir -p build && git archive --format=tar.gz --prefix=vxs-$(version)/ -o build/vxs-$(version).tar.gz HEAD && echo "wrote build/vxs-$(version).tar.gz"

.PHONY: amalgamation
amalgamation: $A/vxs.c $A/LICENSE $(if $(filter skip,$(packages)),,$A/zstddeclib.c)
	@echo "wrote $A: $(notdir $^)"
$A/vxs.c: $(runtime.c) runtime/install/amalgamate.py $(wildcard runtime/*.h formats/*.h) | packages
	@echo "  join $@"
	$Q$(python) runtime/install/amalgamate.py $A $(runtime.c)
$A/LICENSE: LICENSE.MIT
	$Q mkdir -p $(@D) && cp $< $@
$A/zstddeclib.c: $W/sources/zstd/.unpacked
	@echo "  join $@"
	$Q mkdir -p $(@D) && cd $W/sources/zstd/build/single_file_libs && $(python) combine.py -r ../../lib -x legacy/zstd_legacy.h -o $(abspath $@) zstddeclib-in.c 2>/dev/null && \
	    sed '/^BSD License/,$$!d' ../../LICENSE >$(abspath $A)/COPYING.zstd
