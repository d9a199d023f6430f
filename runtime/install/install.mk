# The shared library, manual pages, completion, and what goes where: make install, make deb.
# SPDX-License-Identifier: MIT

OBJCOPY    ?= objcopy
prefix     ?= /usr/local
bindir     ?= $(prefix)/bin
libdir     ?= $(prefix)/lib
includedir ?= $(prefix)/include
datadir    ?= $(prefix)/share
zshdir     ?= $(datadir)/zsh/site-functions

version := $(shell sed -n 's/^\#define VXS_VERSION_[MP][A-Z]* *//p' runtime/vxs.h | paste -sd.)
major   := $(firstword $(subst ., ,$(version)))
headers := runtime/vxs.h runtime/vxs.hpp runtime/vxs_query.h runtime/vxs_stream.h runtime/gl/vxs_gl.h runtime/gl/vxs_gl_depths.h runtime/gl/vxs_cull.h $(volumes.h) $(air.h) $(addprefix formats/,vxs_file.h vxs_format.h vxs_result.h vxs_findings.h vxs_lookup.h vxs_lookup_blocks.h vxs_space.h vxs_smoke.h vxs_depths.h vxs_intervals.h)

# --- libvxs.so: what the headers declare, under one version of symbols for each that breaks programs ----------------------------

pic.o    := $(runtime.c:%=$B/pic/%.o)
gl.pic.o := $(gl.c:%=$B/pic/%.o) $B/pic/runtime/gl/texts.c.o $B/pic/runtime/tile_depths.c.o # which libvxs.so hides
volumes.pic.o := $(volumes.c:%=$B/pic/%.o) $B/pic/runtime/volumes/texts.c.o

$B/libvxs.so: $(pic.o) $B/libvxs.map
	@echo "  link $@"
	$Q$(CC) $(opt) $(linker) -shared -Wl,-soname,libvxs.so.$(major) -Wl,--version-script=$B/libvxs.map -Wl,-Bsymbolic-functions -o $@ \
	    $(pic.o) $(shell $(PKG_CONFIG) --libs libzstd libxxhash) -lm $(LDFLAGS)

$B/libvxs_gl.so: $(gl.pic.o) $B/libvxs.so $B/libvxs_gl.map
	@echo "  link $@"
	$Q$(CC) $(opt) $(linker) -shared -Wl,-soname,libvxs_gl.so.$(major) -Wl,--version-script=$B/libvxs_gl.map -Wl,-Bsymbolic-functions -o $@ \
	    $(gl.pic.o) $B/libvxs.so -lm $(LDFLAGS)

$B/libvxs_volumes.so: $(volumes.pic.o) $B/libvxs_gl.so $B/libvxs.so $B/libvxs_volumes.map
	@echo "  link $@"
	$Q$(CC) $(opt) $(linker) -shared -Wl,-soname,libvxs_volumes.so.$(major) -Wl,--version-script=$B/libvxs_volumes.map -Wl,-Bsymbolic-functions -o $@ \
	    $(volumes.pic.o) $B/libvxs_gl.so $B/libvxs.so -lm $(LDFLAGS)

define compile_pic
	@echo "  pic  $<"
	$Q mkdir -p $(@D) && $(CC) $(cflags) $(pic) $(CPPFLAGS) $(CFLAGS) -c $< -o $@
endef
$B/pic/%.c.o: %.c
	$(compile_pic)
$B/pic/runtime/%/texts.c.o: $B/runtime/%/texts.c
	$(compile_pic)

$B/libvxs.map: runtime/vxs.h runtime/vxs_query.h runtime/vxs_stream.h formats/vxs_file.h
$B/libvxs_gl.map: runtime/gl/vxs_gl.h runtime/gl/vxs_gl_depths.h
$B/libvxs_volumes.map: $(volumes.h)
$B/libvxs.map $B/libvxs_gl.map $B/libvxs_volumes.map:
	$Q mkdir -p $(@D) && { echo "$(if $(findstring _gl,$@),VXS_GL,$(if $(findstring _volumes,$@),VXS_VOLUMES,VXS))_$(major) { global:"; \
	    sed -n '/^typedef\|^static/!s/^[a-z].*[ *]\(vxs_[a-z_]*\)(.*/    \1;/p' $^; echo "local: *; };"; } >$@

# --- libvxs_bake: the objects that baker/vxs_bake.h leads to in one, whose other names are its own -----------------

bake.names = sed -n '/^typedef\|^static/!s/^[a-z].*[ *]\(vxs_bake[a-z_]*\)(.*/$(1)/p' baker/vxs_bake.h

$B/pic.a: $(pic.o) $B/pic/runtime/volumes/area/area_points.c.o
	$Q$(RM) $@ && $(AR) rcsT $@ $^

$B/vxs_bake.o: $B/baker/library/vxs_bake.c.o $B/bake.a $B/pic.a baker/vxs_bake.h
	@echo "  link $@"
	$Q$(LD) -r --force-group-allocation -o $@ $(filter %.o,$^) --start-group $(filter %.a,$^) --end-group
	$Q$(call bake.names,\1) >$@.names && $(OBJCOPY) --keep-global-symbols=$@.names $@

$B/libvxs_bake.a: $B/vxs_bake.o
	@echo "  ar   $@"
	$Q$(RM) $@ && $(AR) rcs $@ $^

$B/libvxs_bake.so: $B/vxs_bake.o $B/libvxs_bake.map
	@echo "  link $@"
	$Q$(CXX) $(opt) $(linker) $(threaded) -shared -Wl,-soname,libvxs_bake.so.$(major) -Wl,--version-script=$B/libvxs_bake.map -o $@ $< \
	    $(shell $(PKG_CONFIG) --libs $(bake.pc)) $(bake.libs) $(LDFLAGS)

$B/libvxs_bake.map: baker/vxs_bake.h
	$Q mkdir -p $(@D) && { echo "VXS_BAKE_$(major) { global:"; $(call bake.names,    \1;); echo "local: *; };"; } >$@

# --- manual pages and completion, which the command makes of its own options ------------------------------------------------------

# when the sources changed last, in seconds: what is made of the same sources is the same
epoch       = $(or $(SOURCE_DATE_EPOCH),$(shell git log -1 --format=%ct 2>/dev/null),$(shell stat -c %Y runtime/vxs.h))
man.1      := $B/man/vxs.1 $(patsubst cmd_%.c,$B/man/vxs-%.1,$(notdir $(wildcard baker/*/cmd_*.c baker/*/*/cmd_*.c)))
completion := $(addprefix $B/completion/vxs.,bash zsh fish)

.PHONY: man
man: $(man.1)
$(man.1): $B/vxs
	$Q mkdir -p $(@D) && $B/vxs $(patsubst vxs-%.1,%,$(filter vxs-%,$(@F))) --help=man >$@ && \
	    sed -i "1s/\"\"/\"$$(date -u -d @$(epoch) +%F)\"/" $@

$(completion): $B/completion/vxs.%: $B/vxs
	$Q mkdir -p $(@D) && $B/vxs --help=$* >$@

# --- install ----------------------------------------------------------------------------------------------------------------------

# folder/path=file (runtime/install/put)
doc.files := README.md LICENSE LICENSE.MIT LICENSE.GPL-3.0 formats/vxs.md scenes/README.md $(wildcard docs/*.md docs/*.json docs/*.png docs/plots/* docs/example/*)
files     := bindir/vxs=$B/vxs \
             libdir/libvxs.a=$B/libvxs.a \
             libdir/libvxs.so.$(version)=$B/libvxs.so \
             libdir/libvxs.so.$(major)=@libvxs.so.$(version) \
             libdir/libvxs.so=@libvxs.so.$(major) \
             libdir/libvxs_gl.a=$B/libvxs_gl.a \
             libdir/libvxs_gl.so.$(version)=$B/libvxs_gl.so \
             libdir/libvxs_gl.so.$(major)=@libvxs_gl.so.$(version) \
             libdir/libvxs_gl.so=@libvxs_gl.so.$(major) \
             libdir/libvxs_volumes.a=$B/libvxs_volumes.a \
             libdir/libvxs_volumes.so.$(version)=$B/libvxs_volumes.so \
             libdir/libvxs_volumes.so.$(major)=@libvxs_volumes.so.$(version) \
             libdir/libvxs_volumes.so=@libvxs_volumes.so.$(major) \
             libdir/libvxs_bake.a=$B/libvxs_bake.a \
             libdir/libvxs_bake.so.$(version)=$B/libvxs_bake.so \
             libdir/libvxs_bake.so.$(major)=@libvxs_bake.so.$(version) \
             libdir/libvxs_bake.so=@libvxs_bake.so.$(major) \
             includedir/vxs/vxs_bake.h=baker/vxs_bake.h \
             libdir/pkgconfig/vxs.pc=runtime/install/vxs.pc.in \
             libdir/pkgconfig/vxs_gl.pc=runtime/install/vxs_gl.pc.in \
             libdir/pkgconfig/vxs_volumes.pc=runtime/install/vxs_volumes.pc.in \
             libdir/pkgconfig/vxs_bake.pc=runtime/install/vxs_bake.pc.in \
             $(foreach f,vxsConfig vxsConfigVersion,libdir/cmake/vxs/$f.cmake=runtime/install/$f.cmake.in) \
             $(foreach f,$(headers),includedir/vxs/$(notdir $f)=$f) \
             $(foreach f,$(man.1),datadir/man/man1/$(notdir $f)=$f) \
             $(if $(or $(wildcard build/web/view.html),$(filter uninstall,$(MAKECMDGOALS))),datadir/vxs/view.html=build/web/view.html) \
             datadir/bash-completion/completions/vxs=$B/completion/vxs.bash \
             zshdir/_vxs=$B/completion/vxs.zsh \
             datadir/fish/vendor_completions.d/vxs.fish=$B/completion/vxs.fish \
             $(foreach f,$(doc.files),datadir/doc/vxs/$f=$f)

.PHONY: install uninstall deb
install uninstall: export DESTDIR := $(DESTDIR)
install uninstall: export prefix := $(prefix)
install uninstall: export bindir := $(bindir)
install uninstall: export libdir := $(libdir)
install uninstall: export includedir := $(includedir)
install uninstall: export datadir := $(datadir)
install uninstall: export zshdir := $(zshdir)
install uninstall: export version := $(version)
install uninstall: export major := $(major)
install: all $(man.1) $(completion)
	@echo "  put  $(DESTDIR)$(prefix)"
	$Q runtime/install/put install $(files)

uninstall:
	$Q runtime/install/put uninstall $(files)

# --- Debian packages: what is installed, parted ------------------------------------------------------------------------------------

multiarch = $(shell dpkg-architecture -qDEB_HOST_MULTIARCH 2>/dev/null)
deb: all packages
	@command -v dpkg-shlibdeps >/dev/null || { echo "make deb needs the package dpkg-dev" >&2; exit 1; }
	$Q$(RM) -r $B/deb
	$Q$(MAKE) --no-print-directory install packages=skip DESTDIR=$(abspath $B/deb/all) prefix=/usr libdir=/usr/lib/$(multiarch) \
	    zshdir=/usr/share/zsh/vendor-completions
	$Q cd $B/deb && SOURCE_DATE_EPOCH=$(epoch) version=$(version) major=$(major) multiarch=$(multiarch) $(CURDIR)/runtime/install/deb $(CURDIR)
