# Sources of libraries that are compiled to WebAssembly, from Debian's source packages.
# SPDX-License-Identifier: MIT
#
#   build/web/sources/NAME/.unpacked    unpacked and patched as Debian does, in build/web/sources/NAME
#
# A table has a line for each: NAME, package, version, SHA-256 of the package's .dsc, which has those of all of its files.
# web.libraries: all tables. apt has its own lists in build/web/apt: no setting of the system is read or changed.

web.libraries += runtime/web/libraries.txt
web.apt       := $W/apt
web.mirror    ?= http://deb.debian.org
web.suites    ?= debian=bookworm debian-security=bookworm-security

apt_here = $(abspath $(web.apt))
apt_get   = apt-get -q -o Dir::Etc::SourceList=$(apt_here)/sources.list -o Dir::Etc::SourceParts=/dev/null -o Dir::State::Lists=$(apt_here)/lists \
            -o Dir::Cache=$(apt_here)/cache -o APT::Sandbox::User=root -o APT::Get::List-Cleanup=0

$(web.apt)/updated: runtime/web/libraries.mk
	$Q mkdir -p $(web.apt)/lists/partial $(web.apt)/cache/archives/partial
	$Q for s in $(web.suites); do echo "deb-src [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $(web.mirror)/$${s%=*} $${s#*=} main"; \
	    done >$(web.apt)/sources.list
	$Q $(apt_get) update >$(web.apt)/update.log 2>&1 || { cat $(web.apt)/update.log >&2; exit 1; }
	$Q touch $@

$W/sources/%/.unpacked: $(web.libraries) | packages $(web.apt)/updated
	@echo "  deb  $*"
	$Q set -e; set -- $$(awk -v name=$* '$$1 == name { print $$2, $$3, $$4 }' $(web.libraries)); \
	[ $$# = 3 ] || { echo "$*: no line in $(web.libraries)" >&2; exit 1; }; \
	rm -rf $W/sources/$*; mkdir -p $W/sources/$*.deb; cd $W/sources/$*.deb; \
	$(apt_get) source --download-only $$1=$$2 >log 2>&1 || { cat log >&2; exit 1; }; \
	dsc=$$(ls *.dsc); echo "$$3  $$dsc" | sha256sum -c --quiet; \
	dpkg-source --no-check -x $$dsc ../$* >log 2>&1 || { cat log >&2; exit 1; }; \
	cd ..; rm -r $*.deb; touch $*/.unpacked
.PRECIOUS: $W/sources/%/.unpacked
