# vxs: precomputed voxelized shadows. The only build description, with runtime/install/install.mk.
#
#   make                build the command and the libraries of the runtime, its OpenGL, and the bake: build/release/vxs, libvxs.a and .so,
#                       libvxs_gl.a and .so, libvxs_bake.a and .so; and vxs-mpi, where there is an mpicc
#   make core=1         the same without the laboratory (baker/lab), which needs OpenGL, Embree and OpenEXR: build/release/vxs-core, libvxs and libvxs_bake
#   make core=1 threads=1   the same without a thread library, in build/release-1: bakes run on one thread, steps of libvxs_bake run to the end
#   make demo           install what is missing, build, bake a city, compare it with ray-traced truth, draw it
#   make check          install what is missing, build, run every test but for what check-repeats adds
#   make check-fast     the same without what is slow: under a minute on two processors, once all is built
#   make check-unit     the same, unit tests only; config=asan runs them under the address and undefined sanitizers
#   make check-asan     the same under those sanitizers, without programs that read no bytes of files and take long there
#   make check-sanitizers  all unit programs and the corpora of all fuzzers under those sanitizers and under that of threads, and bakes with 2 and 8
#                       threads under that: some hours
#   make check-repeats  every test with all its random inputs, of which the others take a part, and tests marked long, and unit programs that check
#                       leaves out (long.unit): half an hour; before an issue is resolved
#   make check-exact    every voxel of maps twice as fine, and ten times as many columns of fine ones: some minutes
#   make check-memory   bake every real scene within half and twice of the memory that it needs, watched from outside: a minute
#   make check-faults   kill bakes and ranks 50 times each, flip every bit, and bake large maps with too little memory: some minutes
#   make check-sparse   maps straight from triangles, at length: stress scenes, rendered maps, 262144 texels a side; half an hour, or part=stress,
#                       sources or columns (tests/exact/sparse.py)
#   make check-cracks   look for light between sheets that meet, in 100 million columns of each source of maps: a minute
#   make fuzz           build the fuzzers with clang: build/fuzz/tests/fuzz/fuzz_*, which run until they find something. seconds=60: run each of them,
#                       and fuzz-commands, for so long, with a line for each; seed=2 tries other inputs, only=fuzz_answers runs one
#   make fuzz-pack      add inputs to a fuzzer's corpus: corpus=vxs inputs=build/fuzz/found/vxs, files or folders (tests/fuzz/corpus.py)
#   make fuzz-minimise  leave out inputs that no fuzzer needs for its coverage; those that once showed a fault stay
#   make fuzz-commands  random command lines over files of all kinds, for seconds=60; config=asan finds more, seed=2 tries others
#   make bench          measure; a table to read, and JSON to $(BENCH_JSON)
#   make bench-large    measure maps of up to 262144 texels a side, straight from triangles: three minutes; JSON to build/large.json;
#                       against=VXS: beside another build of the command
#   make bench-lights   measure frames lit by 165 spot lights; JSON to build/lights.json (tests/bench/lights.py: gl=egl for a graphics card)
#   make check-drivers  unit programs that draw, with other OpenGL drivers: llvmpipe by EGL, zink, softpipe; driver=zink: one
#   make bench-gpu      measure lookups, lists of lights and fog beside rivals: some minutes; VXS_GL=egl size=1920x1080 for a graphics card; JSON to
#                       build/gpu.json (tests/bench/gpu.py)
#   make bench-volumes  measure error against time of shadows in fog, smoke and area lights, each technique and its rivals: half an hour; JSON and a page to
#                       build/volumes.json and .html, plots beside, tables to read. only=room, values=2: of some scenes, of each knob
#   make gpu-kit        pack what a machine with a graphics processor needs to run unit programs and benches: build/gpu-kit.tar.xz, with a run.sh
#   make bench-smoke    the same of smoke, hair and leaves alone
#   make bench-bias     acne, leaks and peter-panning of lookups with a normal: an hour; JSON to build/bias.json
#   make bench-flight   fly over a city within 4 MiB, at 16384 and 65536 texels a side: four minutes; JSON to build/flight_*.json
#   make program-size   print the SPIR-V instructions of every program for graphics processors, and their ceilings
#   make amalgamation   the runtime as two files, vxs.h and vxs.c, and zstd's decoder as a third: build/amalgamation
#   make wheel          the Python module with its libraries, for pip: build/wheel (docs/python.md)
#   make dist           the sources of the last commit: build/vxs-VERSION.tar.gz
#   make wgsl           translate lookups, and with them intervals of rays and their fog, for WebGPU: build/release/vxs_lookup.wgsl,
#                       vxs_intervals.wgsl, vxs_fog.wgsl. Needs naga-cli of crates.io and glslang-tools. only="KIND=1 CODING=2" leaves out code
#                       for other lights, as VXS_ONLY_KIND and VXS_ONLY_CODING do in shaders
#   make web            the npm package: the command, the runtime and three.js lights for Node and browsers, in build/web/vxs (docs/web.md)
#   make check-web      test that package, with Chromium; only=NAME runs tests/web/*NAME*; check-web-fast: its runtime alone, a minute
#   make blender        the Blender add-on: build/blender/vxs_shadows-VERSION.zip; install-blender installs it
#   make check-blender  test the add-on for Blender in what Blenders there are; BPY=/path/to/python also in its module bpy; only=NAME
#   make bench-blender  time bakes by the add-on, of a million triangles, beside the command alone: some minutes
#   make compare-cycles measure vxs beside lightmaps of Cycles, in BLENDER=blender or a Python with bpy: some minutes; JSON and pictures in build/blender
#   make godot          the add-on for Godot 4: build/godot/addons/vxs and a zip (docs/godot.md)
#   make check-godot    test it in Godot's web template, which npm has, in Chromium; only=NAME
#   make web-compare    draw levels in a browser by shadow maps, lightmaps and baked shadows, beside ray-traced truth: build/web/compare/index.html
#   make install        to $(DESTDIR)$(prefix), which may hold blanks; uninstall takes it away (runtime/install/)
#   make man            manual pages, in build/release/man
#   make deb            Debian packages, in build/release/deb
#   make format         lay the sources out with clang-format
#   make clean
#
# config=debug|release|asan|tsan selects flags; each has its own object tree, so flags never mix. werror=1 makes warnings
# errors. CFLAGS, CXXFLAGS, CPPFLAGS and LDFLAGS are the user's and come last. V=1 prints the commands. packages=skip
# leaves the system alone. Settings to keep go to Makefile.config.

-include Makefile.config

config     ?= release
BENCH_JSON ?= build/bench.json
CHART_JS   ?= /usr/share/javascript/chart.js/chart.min.js
PKG_CONFIG ?= pkg-config
MPICC      ?= mpicc
B          := build/$(config)$(threads:%=-%)
Q          := $(if $(V),,@)

# --- packages of Debian; docs/dependencies.md says what each is for -------------------------------------------------------

packages.build := g++ gcc make pkg-config libosmesa6-dev libegl-dev libgl-dev libcgal-dev libtinygltf-dev \
                  nlohmann-json3-dev libzstd-dev libxxhash-dev libembree-dev libjansson-dev \
                  libdraco-dev libmeshoptimizer-dev libpng-dev libwebp-dev libopenexr-dev libjs-chart.js
ifdef core
packages.build := $(filter-out libosmesa6-dev libegl-dev libgl-dev libembree-dev libopenexr-dev libjs-chart.js,$(packages.build))
endif
packages.test  := python3 python3-pytest python3-pytest-xdist python3-jsonschema libcmocka-dev libgsl-dev glslang-tools spirv-tools libvulkan-dev mesa-vulkan-drivers zlib1g-dev gnuplot-nox chromium \
                  groff-base zsh fish cmake python3-numpy
packages.deb   := dpkg-dev
# Debian's, which sees Debian's packages; another one may come first on PATH
python         := /usr/bin/python3

# --- flags ----------------------------------------------------------------------------------------------------------------

# what is delivered is hardened as Debian's packages are (dpkg-buildflags with hardening=+bindnow)
hardened    := -fstack-protector-strong $(if $(findstring FORTIFY_SOURCE,$(CPPFLAGS) $(CFLAGS) $(CXXFLAGS)),,-D_FORTIFY_SOURCE=2)
link.release := -Wl,-z,relro -Wl,-z,now
opt.debug   := -Og -g -DXXH_NO_INLINE_HINTS=1
opt.release := -O3 -g1 $(hardened)
opt.asan    := -O1 -g1 -fsanitize=address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
opt.tsan    := -O1 -g1 -fsanitize=thread
opt.fuzz    := -O1 -g -fsanitize=fuzzer-no-link,address,undefined -fno-sanitize-recover=all -fno-omit-frame-pointer
opt         := $(or $(opt.$(config)),$(error unknown config '$(config)': expected debug, release, asan or tsan))
ifeq ($(config),fuzz)
CC         := clang
CXX        := clang++
endif

warn        := -Wall -Wextra -Wshadow -Wpointer-arith $(if $(werror),-Werror)
threaded    := $(if $(filter-out 1,$(threads)),$(error unknown threads '$(threads)': expected 1))$(if $(threads),,-pthread)
flags       := -I. -Iformats -Iruntime -Iruntime/gl $(patsubst %/,-I%,$(wildcard runtime/volumes/ runtime/volumes/*/)) -MMD -MP -ffp-contract=off $(or $(threaded),-DVXS_ONE_THREAD -DCGAL_HAS_NO_THREADS) $(opt)
cflags      := -std=c11 -D_GNU_SOURCE $(warn) -Wstrict-prototypes -Wmissing-prototypes $(flags)
pic         := -fPIC -fno-semantic-interposition
# under sanitizers programs are large, and gold, where there is one, links them in a third of the time
linker       = $(link.$(config)) $(if $(filter asan,$(config)),$(if $(shell command -v ld.gold),-fuse-ld=gold))
cxxflags    := -std=c++17 -Wall -Wextra $(if $(werror),-Werror) $(flags)
# looked up when the first link needs it: before, pkg-config itself may not be there
bake.pc      := libzstd libxxhash jansson libpng libwebp
bake.libs    := -ldraco -lmeshoptimizer -lgmp -lmpfr -lm
core.libs    = $(shell $(PKG_CONFIG) --libs $(bake.pc)) $(bake.libs)
libs         = $(eval libs := $(shell $(PKG_CONFIG) --libs $(bake.pc)) $(bake.libs) -lOpenEXRCore -lembree3 -ldl)$(libs)

# --- what is built --------------------------------------------------------------------------------------------------------

# a bake by many processes; the program is there where an MPI is
mpi.c     := $(wildcard baker/command/mpi/*.c)
mpi.o     := $(mpi.c:%=$B/%.o)
mpi       := $(if $(shell command -v $(MPICC)),$B/vxs-mpi)
runtime.c := $(wildcard runtime/*.c formats/vxs_read*.c formats/vxs_page_decode.c formats/vxs_page_check.c formats/vxs_resident_check.c)
gl.c      := $(wildcard runtime/gl/*.c)
# smoke comes with lights, so that there are as many texts as programs know of
gl.text   := $(filter-out %/lights.glsl %/words.glsl %/tables.glsl,$(wildcard runtime/gl/*.glsl)) $B/runtime/gl/words_tables.glsl $(addprefix formats/,vxs_lookup.h vxs_lookup_blocks.h vxs_space.h vxs_depths.h) runtime/gl/vxs_cull.h $B/runtime/gl/smoke_lights.glsl
# what its functions are declared in, and texts for C and shaders
volumes.h := $(addprefix runtime/volumes/,vxs_volumes.h vxs_transmittance.h vxs_area_light.h vxs_capsule.h)
air.h     := $(filter-out $(volumes.h),$(wildcard runtime/volumes/vxs_*.h))
volumes.c := $(wildcard runtime/volumes/*.c runtime/volumes/*/*.c)
volumes.text := $(wildcard runtime/volumes/*.glsl runtime/volumes/*/*.glsl) runtime/gl/first_shadow.glsl $(air.h) formats/vxs_depths.h formats/vxs_intervals.h
format.c  := $(filter-out $(runtime.c),$(wildcard formats/*.c))
# libvxs_bake, which the command links; the command; and the laboratory, which measures, compares, draws, mends and generates: vxs-core is the
# command without it
bake.rooms := base files scene scene/gltf casters light columns columns/sparse coding/blocks coding/dag smoke bake bake/cache
bake.c    := $(foreach r,$(bake.rooms),$(wildcard baker/$r/*.c))
library.c := $(wildcard baker/library/*.c)
no_lab.c  := baker/command/options/no_laboratory.c
command.c := $(filter-out $(no_lab.c),$(wildcard baker/command/*.c $(foreach r,options report process,baker/command/$r/*.c)))
lab.c     := $(wildcard baker/lab/*/*.c scenes/*.c)
library.o := $(library.c:%=$B/%.o)
runtime.o := $(runtime.c:%=$B/%.o)
gl.o      := $(gl.c:%=$B/%.o) $B/runtime/gl/texts.c.o
volumes.o := $(volumes.c:%=$B/%.o) $B/runtime/volumes/texts.c.o
# what takes longest to compile comes first, so that no processor waits for it in the end
lab.o     := $(patsubst %,$B/%.o,$(wildcard baker/lab/mend/*.cc) $(lab.c))
bake.o    := $(patsubst %,$B/%.o,$(wildcard baker/casters/*.cc baker/scene/gltf/*.cc) $(bake.c) $(format.c))
command.o := $(patsubst %,$B/%.o,$(command.c) $(wildcard baker/command/process/*.cc))
# what is compiled for several processors (baker/base/cpu.h): once more for each, with the level in the names of its functions
ifneq ($(findstring x86_64,$(MAKE_HOST)),)
level.c   := baker/columns/sparse/leaf.c baker/columns/sparse/square_list.c
bake.o    += $(level.c:%=$B/%.avx2.o) $(level.c:%=$B/%.avx512.o)
endif
# with CGAL's templates, which take 35 s to compile under sanitizers: check-asan links those of release, check-unit config=asan its own
cgal      := $(wildcard baker/lab/mend/*.cc baker/casters/*.cc)
of_release = $(patsubst %,build/release/%.o,$(filter $(patsubst $B/%.o,%,$1),$(unsanitized))) $(filter-out $(unsanitized:%=$B/%.o),$1)
bake.o    := $(call of_release,$(bake.o))
lab.o     := $(call of_release,$(lab.o))
# files that go into the command as they are; baker/base/embedded.h names their bytes
lab.data  := $(patsubst %,$B/%.o,$(wildcard baker/lab/pages/*.html baker/lab/pages/*.js baker/lab/render/*.glsl) $(addprefix runtime/volumes/,smoke/capsule.glsl vxs_air_light.h)) $B/baker/lab/pages/chart.min.js.o
command.data := $(patsubst %,$B/%.o,$(wildcard baker/command/options/completion.*))
embedded  := $(lab.data) $(command.data)
lab.o     += $(lab.data)
command.o += $(command.data)
baker.o   := $(lab.o) $(bake.o) $(command.o)
# what check-asan leaves to `make check-unit config=asan`: programs that read no bytes of files, take 4 s or more there to draw (llvmpipe's code,
# mostly), to trace rays or to bake, and call functions that others call, too; but for compare, generate, and one function that volumes calls
long.asan := air area_floor area_pull_push area_light area_sky area_slope area_smoke area_uses bias blocks build casters compare cracks dag depth_gl generate gl_depths gl_stream half intervals_gl light_mesh lit_intervals mesh \
             mesh_adaptive mesh_meet mesh_split program_cache rival_areas rival_curves rival_volumes shaders shadow_grid smoke_map sparse sparse_key transmittance \
             transmittance_fog truth volumes volumes_grid voxelize voxelize_fog
# what check leaves to check-repeats: of techniques that volumes are only measured against, which tests/cli/test_measurements.py runs, too
long.unit := rival_curves rival_volumes
ifneq ($(filter check check-fast,$(MAKECMDGOALS)),)
without   ?= $(long.unit)
endif
unit      := $(filter-out $(without:%=$B/tests/unit/test_%),$(patsubst %.c,$B/%,$(wildcard tests/unit/test_*.c)))
helper    := $(patsubst %.c,$B/%,tests/exact/exact.c $(filter-out tests/bench/rival_% tests/bench/volumes_% tests/bench/gpu_%,$(wildcard tests/bench/*.c)))
exact.o   := $(patsubst %,$B/%.o,$(filter-out %/exact.c,$(wildcard tests/exact/*.c)))
rival.o   := $(patsubst %.c,$B/%.c.o,$(wildcard tests/bench/rival_*.c))
volumes_bench.o := $(patsubst %.c,$B/%.c.o,$(wildcard tests/bench/volumes_*.c))
gpu.o     := $(patsubst %.c,$B/%.c.o,$(wildcard tests/bench/gpu_*.c))
# the reference of light in the air, and rivals there, with their shaders
reference.o := $(patsubst %,$B/%.o,$(wildcard tests/volumes/*.c tests/volumes/*.glsl))
# that rivals hand to a compiler of shaders
shader    := $(patsubst %,$B/%.o,formats/vxs_lookup.h formats/vxs_lookup_blocks.h $(wildcard tests/volumes/*.glsl))
# fuzz_NAME.c or .cc, with a loop around it: libFuzzer's, and mutate_NAME.c where there is one; or a replay of the corpus
fuzz.c    := $(wildcard tests/fuzz/fuzz_*.c tests/fuzz/fuzz_*.cc)
fuzz      := $(addprefix $B/,$(basename $(fuzz.c)))
# programs whose bytes are .vxs files have the changes and the corpus of fuzz_vxs (tests/fuzz/corpus/NAME.tar.xz is a link to it)
fuzz.vxs  := tests/fuzz/fuzz_vxs.c tests/fuzz/fuzz_answers.c tests/fuzz/fuzz_shaders.c
fuzz.loop  = $(if $(filter fuzz,$(config)),$(if $(filter $(fuzz.vxs),$1),tests/fuzz/mutate_vxs.c,$(wildcard $(1:tests/fuzz/fuzz_%=tests/fuzz/mutate_%))),tests/fuzz/replay.c)
test.o    := $(patsubst $B/%,$B/%.c.o,$(unit) $(helper)) $(patsubst %,$B/%.o,$(fuzz.c) $(foreach f,$(fuzz.c),$(call fuzz.loop,$f))) $(exact.o) $(rival.o) $(volumes_bench.o) $(gpu.o) $(reference.o) $B/tests/unit/blocks_scalar.c.o $B/tests/unit/lookup_many_scalar.c.o
objects    = $(no_lab.c:%=$B/%.o) $(if $(mpi),$(mpi.o),$B/baker/command/mpi/square_scheduler.c.o) $B/baker/main.c.o $(baker.o) $(library.o) $(runtime.o) $(gl.o) $(volumes.o) $(pic.o) $(gl.pic.o) $(volumes.pic.o) $(test.o)

.DELETE_ON_ERROR:
.PHONY: all unit fuzz fuzzers fuzz-pack fuzz-minimise fuzz-commands demo check check-fast check-unit check-asan check-repeats check-drivers check-exact check-memory check-faults check-sparse check-cracks check-sanitizers bench bench-bias bench-flight bench-gpu bench-large bench-lights bench-volumes bench-smoke program-size gpu-kit wgsl packages format clean
ifdef core
all: $B/vxs-core $B/libvxs.a $B/libvxs.so $B/libvxs_bake.a $B/libvxs_bake.so
else
all: $B/vxs $B/vxs-core $(mpi) $B/libvxs.a $B/libvxs.so $B/libvxs_gl.a $B/libvxs_gl.so $B/libvxs_volumes.a $B/libvxs_volumes.so $B/libvxs_bake.a $B/libvxs_bake.so
endif
unit: $(unit) $(helper) $(fuzz)

include runtime/install/install.mk
include runtime/web/web.mk
include baker/blender/blender.mk
include tests/blender/blender.mk
include runtime/install/amalgamation.mk
include runtime/python/python.mk
include runtime/godot/godot.mk

$B/vxs-core: $B/baker/main.c.o $(command.o) $(no_lab.c:%=$B/%.o) $B/bake.a $B/libvxs_volumes.a $B/libvxs.a
$B/vxs-core: libs = $(core.libs)
$B/vxs: $B/baker/main.c.o $(lab.o) $(command.o) $B/bake.a $B/libvxs_volumes.a $B/libvxs_gl.a $B/libvxs.a
ifdef mpi
$(mpi): $(mpi.o) $B/baker.a $B/libvxs_volumes.a $B/libvxs_gl.a $B/libvxs.a
$(mpi): test_libs = $(shell $(MPICC) --showme:link)
$(mpi.o): cflags += $(shell $(MPICC) --showme:compile)
endif
$B/bake.a: $(bake.o) $(library.o)
# an archive: what a test does not call is not linked into it, which takes the linker a quarter of the time
$B/baker.a: $(baker.o) $(library.o)
$B/bake.a $B/baker.a:
	$Q$(RM) $@ && $(AR) rcsT $@ $^
$(unit) $(helper): $B/%: $B/%.c.o $B/baker.a $B/libvxs_volumes.a $B/libvxs_gl.a $B/libvxs.a
$(unit): test_libs := -lcmocka
reference := $(patsubst %,$B/tests/unit/test_%,air area_smoke reference metrics rival_areas rival_curves rival_volumes smoke_map smoke_quads transmittance \
                 transmittance_draw transmittance_fog volumes)
$(reference): $(reference.o)
$(reference): test_libs += -lgsl -lgslcblas
$B/tests/unit/test_lookup_blocks $B/tests/unit/test_gl: $B/tests/unit/blocks_scalar.c.o
$B/tests/unit/test_lookup_many $B/tests/unit/test_gl: $B/tests/unit/lookup_many_scalar.c.o
$B/tests/unit/test_square_scheduler: $B/baker/command/mpi/square_scheduler.c.o
# what they test is optimised as it is delivered; they themselves take longer to compile than to run
$(patsubst %,$B/%.o,$(wildcard tests/unit/*.c)): cflags += $(if $(filter release,$(config)),-O1)
$B/tests/exact/exact: $(exact.o)
$B/tests/bench/rivals: $(rival.o) $(filter-out $B/tests/%,$(shader))
$B/tests/bench/rivals: test_libs := -lz
$(patsubst %,$B/tests/bench/%,volumes smoke area): $(volumes_bench.o) $(reference.o)
$(patsubst %,$B/tests/bench/%,volumes smoke area gpu): test_libs := -lgsl -lgslcblas
$B/tests/bench/gpu: $(gpu.o) $(reference.o)
$B/vxs $B/vxs-core $(mpi) $(unit) $(helper):
	@echo "  link $@"
	$Q$(CXX) $(opt) $(linker) $(threaded) -o $@ $(filter %.o,$^) $(filter %.a,$^) $(test_libs) $(libs) $(LDFLAGS)

$(foreach f,$(fuzz.c),$(eval $B/$(basename $f): $(patsubst %,$B/%.o,$f $(call fuzz.loop,$f))))
$(filter-out %/fuzz_vxs %/fuzz_answers,$(fuzz)): $B/baker.a $B/libvxs_volumes.a $B/libvxs_gl.a # those two stand on the runtime alone
$(fuzz): $B/libvxs.a
$(fuzz):
	@echo "  link $@"
	$Q$(CXX) $(opt) $(linker) $(if $(filter fuzz,$(config)),-fsanitize=fuzzer) $(threaded) -o $@ $(filter %.o,$^) $(filter %.a,$^) $(test_libs) $(libs) $(LDFLAGS)

# the corpora, unpacked once, before a fuzz program runs
$(fuzz): | build/corpus
build/corpus: $(wildcard tests/fuzz/corpus/*.tar.xz)
	@echo "  data $@"
	$Q$(python) tests/fuzz/corpus.py unpack

fuzzers: $(fuzz)
fuzz:
	@command -v clang >/dev/null || { echo "make fuzz needs clang with its run-time library; Debian: clang libclang-rt-dev" >&2; exit 1; }
	@$(MAKE) config=fuzz fuzzers
ifdef seconds
	@$(if $(only),,$(MAKE) config=release build/release/vxs)
	@$(python) tests/fuzz/run.py $(or $(only:%=build/fuzz/tests/fuzz/%),$(patsubst $B/%,build/fuzz/%,$(fuzz)) --vxs build/release/vxs) \
	    --seconds $(seconds) --seed $(or $(seed),1)
endif
fuzz-pack:
	@$(python) tests/fuzz/corpus.py pack $(corpus) $(inputs)
fuzz-minimise: fuzz
	@$(python) tests/fuzz/corpus.py minimise
fuzz-commands: $B/vxs
	@$(python) tests/fuzz/command_lines.py --vxs $< --seconds $(or $(seconds),60) --seed $(or $(seed),1)

$B/libvxs.a: $(runtime.o)
$B/libvxs_gl.a: $(gl.o)
$B/libvxs_volumes.a: $(volumes.o)
$B/libvxs.a $B/libvxs_gl.a $B/libvxs_volumes.a:
	@echo "  ar   $@"
	$Q$(RM) $@ && $(AR) rcs $@ $^

# texts of shaders as C strings: what every compiler takes
$B/runtime/gl/texts.c: $(gl.text) Makefile
	$Q mkdir -p $(@D) && for f in $(gl.text); do n=vxs_gl_text_$$(basename $$f | tr . _); \
	    echo "extern const char $$n[];"; echo "const char $$n[] ="; \
	    sed 's/[\\"]/\\&/g; s/^/    "/; s/$$/\\n"/' $$f; echo "    ;"; done >$@
$B/runtime/gl/smoke_lights.glsl: formats/vxs_smoke.h runtime/gl/lights.glsl
$B/runtime/gl/words_tables.glsl: runtime/gl/words.glsl runtime/gl/tables.glsl
$B/runtime/gl/smoke_lights.glsl $B/runtime/gl/words_tables.glsl:
	$Q mkdir -p $(@D) && cat $^ >$@
# and as volumes_text.h has them: a line #include of another text becomes an entry of `needs`
$B/runtime/volumes/texts.c: $(volumes.text) Makefile
	$Q mkdir -p $(@D) && awk ' \
	    function id(f) { sub(/.*\//, "", f); gsub(/\./, "_", f); return "vxs_volumes_text_" f } \
	    function finish() { printf "static const volumes_text *const needs_of_%s[] = {%sNULL};\nconst volumes_text %s = {\n%s    , needs_of_%s};\n", n, needs, n, text, n } \
	    BEGIN { print "#include <stddef.h>\n#include \"runtime/volumes/volumes_text.h\""; \
	        for (i = 1; i < ARGC; i++) { known[id(ARGV[i])]; printf "extern const volumes_text %s;\n", id(ARGV[i]) } } \
	    FNR == 1 { if (n != "") finish(); n = id(FILENAME); text = needs = "" } \
	    /^#include "/ { split($$0, part, "\""); if (id(part[2]) in known) { needs = needs "&" id(part[2]) ", "; next } } \
	    { gsub(/[\\"]/, "\\\\&"); text = text "    \"" $$0 "\\n\"\n" } \
	    END { finish() }' $(volumes.text) >$@
$B/runtime/%/texts.c.o: $B/runtime/%/texts.c
	$(compile)
# naga takes no directives but #version, and writes an entry point, which is cut off. A pointer to a part of a struct is not WGSL
# everywhere, and naga itself cannot compile it: a copy is passed
wgsl: head := runtime/install/wgsl.glsl
wgsl:
	@for tool in glslangValidator naga; do command -v $$tool >/dev/null || { \
	    echo "make wgsl needs $$tool: package glslang-tools; cargo install naga-cli" >&2; exit 1; }; done
	$Q mkdir -p $B/wgsl && for text in lookup intervals fog; do \
	    glslangValidator -E -S comp -Iformats -Iruntime/gl -Iruntime/volumes -Iruntime/web/three -DWITH_$$text $(only:%=-DVXS_ONLY_%) $(head) >$B/wgsl/$$text.comp && \
	    sed -i '/^#extension/d; /^#line/d' $B/wgsl/$$text.comp && \
	    naga --input-kind glsl --shader-stage compute $B/wgsl/$$text.comp $B/wgsl/$$text.wgsl || exit 1; \
	    { sed -n '/^\/\//p' $(head); echo; sed -E -e '/^fn vxs_word_at\(/,/^\}/d; /^fn main_1\(/,$$d' \
	        -e 's/^( *)(vxs_.*, \(&)(\w+\.\w+|\(\*\w+\)\.\w+)\)\);$$/\1{ var part = \3; \2part)); \3 = part; }/' $B/wgsl/$$text.wgsl; \
	    } >$B/vxs_$$text.wgsl; echo "wrote $B/vxs_$$text.wgsl"; done

$(patsubst %,$B/%.o,$(wildcard baker/casters/*.cc baker/lab/mend/*.cc)): cxxflags += -frounding-math $(if $(filter fuzz,$(config)),,-Wno-maybe-uninitialized) # the first for its exact predicates, the second is wrong about it
# CGAL is templates, for which a compiler takes long: not optimised under sanitizers. Its filling of holes is without triangulations in a plane,
# which are off unless asked for, and with the sanitizer of addresses alone; so is tinygltf, which one file has in it
$(patsubst %,$B/%.o,$(wildcard baker/casters/*.cc baker/lab/mend/*.cc)): cxxflags += $(if $(filter asan,$(config)),-O0)
$B/baker/lab/mend/mesh_hole.cc.o: cxxflags += -DCGAL_HOLE_FILLING_DO_NOT_USE_CDT2
$B/baker/lab/mend/mesh_hole.cc.o $B/baker/scene/gltf/gltf_parse.cc.o: cxxflags += $(if $(filter asan,$(config)),-O0 -fno-sanitize=undefined)

# most of what a file of the loader takes to compile is these headers, which are read once; each includes them first (gcc's rule)
gltf.o   := $(patsubst %,$B/%.o,$(filter-out %/gltf_parse.cc,$(wildcard baker/scene/gltf/*.cc)))
gltf.gch := $B/baker/scene/gltf/gltf_loader.h.gch
$(gltf.o): cxxflags += -iquote $B
$(gltf.o): $(gltf.gch)

# the command's objects are those of a shared library, too, and of an archive, in which gcc's unique names cannot be hidden
$(baker.o) $(library.o) $(no_lab.c:%=$B/%.o): cflags += $(pic)
$(baker.o) $(library.o) $(gltf.gch): cxxflags += $(pic) $(if $(filter fuzz,$(config)),,-fno-gnu-unique)
# vectors of two registers are passed within the file alone
$(level.c:%=$B/%.o): cflags += -Wno-psabi
$B/%.c.avx2.o: cflags += -mavx2 -mpopcnt
$B/%.c.avx512.o: cflags += -mavx2 -mpopcnt -mavx512f -mavx512dq -mavx512vl
define compile
	@echo "  cc   $<$(@:$B/$<%.o=%)"
	$Q mkdir -p $(@D) && $(CC) $(cflags) $(CPPFLAGS) $(CFLAGS) -c $< -o $@
endef
$B/%.c.o: %.c
	$(compile)
$B/%.c.avx2.o: %.c
	$(compile)
$B/%.c.avx512.o: %.c
	$(compile)

define compile_cxx
	@echo "  c++  $<"
	$Q mkdir -p $(@D) && $(CXX) $(cxxflags) $(CPPFLAGS) $(CXXFLAGS) $1 -c $< -o $@
endef
$B/%.cc.o: %.cc
	$(call compile_cxx)
$(gltf.gch): $B/%.gch: %
	$(call compile_cxx,-x c++-header)

$(filter-out %/chart.min.js.o,$(embedded)) $(shader): $B/%.o: %
$B/baker/lab/pages/chart.min.js.o: $(CHART_JS)
$(embedded) $(shader):
	@echo "  data $<"
	$Q mkdir -p $(@D) && cd $(<D) && $(LD) -r -b binary -z noexecstack -o $(abspath $@) $(<F)
$(CHART_JS): ; # it may come with a package that is yet to be installed

# --- demo, check, bench: on a bare system, and with all processors ----------------------------------------------------------

ifneq ($(filter demo check check-fast check-unit check-asan check-repeats check-sanitizers bench deb wheel $(web.goals) packages,$(MAKECMDGOALS)),)
jobs := $(if $(findstring -j,$(MAKEFLAGS)),,-j$(shell nproc))
MAKEFLAGS += $(jobs)
$(objects) $(gltf.gch) build/corpus: | packages # nothing is compiled before the headers are there, or unpacked before python3 is
endif

# `make demo` compiles no tests, and needs none of their packages
tested = $(filter check check-fast check-unit check-asan check-repeats check-sanitizers bench packages,$(MAKECMDGOALS))
needed = $(if $(filter-out amalgamation,$(MAKECMDGOALS)),$(packages.build)) $(if $(filter wheel,$(MAKECMDGOALS)),$(packages.wheel)) \
         $(if $(filter amalgamation,$(MAKECMDGOALS)),$(packages.amalgamation)) $(if $(tested),$(packages.test)) $(if $(tested)$(filter deb,$(MAKECMDGOALS)),$(packages.deb)) $(if $(filter $(web.goals),$(MAKECMDGOALS)),$(packages.web))
packages:
ifneq ($(packages),skip)
	@here=$$(dpkg-query -W -f '$${Package} $${db:Status-Status}\n' $(needed) 2>/dev/null | sed -n 's/ installed$$//p'); \
	missing=; for p in $(needed); do echo "$$here" | grep -qxF -e "$$p" || missing="$$missing $$p"; done; \
	[ -n "$$missing" ] || exit 0; \
	how="install them, or what takes their place, and run make again with packages=skip"; \
	echo "vxs needs packages that are not installed:$$missing"; \
	command -v apt-get >/dev/null || { echo "there is no apt-get here: $$how" >&2; exit 1; }; \
	root=; [ "$$(id -u)" = 0 ] || root=sudo; \
	[ -z "$$root" ] || command -v sudo >/dev/null || { echo "not root, and there is no sudo: $$how" >&2; exit 1; }; \
	install="$$root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends$$missing"; \
	echo "installing: $$install"; \
	apt-get install -s --no-install-recommends $$missing >/dev/null 2>&1 || $$root apt-get update -q; \
	$$install
endif

D := build/demo
demo: $B/vxs
	@mkdir -p $D
	$B/vxs scene city -o $D/city.glb
	$B/vxs bake $D/city.glb -o $D/city.vxs --json $D/bake.json
	$B/vxs compare $D/city.glb $D/city.vxs --points 100000 --bake-report $D/bake.json \
		--json $D/compare.json
	$B/vxs render $D/city.glb $D/city.vxs -o $D/city.png
	@echo; echo "scene $D/city.glb, shadows $D/city.vxs, picture $D/city.png, reports $D/bake.json and $D/compare.json"

check: all unit
	@VXS_FLAGS="$(opt)" $(python) tests/run --build $B --without $(without)
check-fast: all unit
	@VXS_FLAGS="$(opt)" $(python) tests/run --build $B --fast --without $(without)
check-unit: $(unit) $(fuzz)
	@$(python) tests/run --build $B --unit --without $(without)
check-asan: packages
	@$(MAKE) config=release packages=skip $(cgal:%=build/release/%.o)
	@$(MAKE) config=asan packages=skip without="$(long.asan)" unsanitized="$(cgal)" check-unit
check-repeats: all unit
	@VXS_TEST_REPEATS=all VXS_FLAGS="$(opt)" $(python) tests/run --build $B
check-drivers: all unit
	@$(python) tests/gpu/drivers.py --build $B $(if $(driver),--driver $(driver))
check-exact: $B/vxs $B/tests/exact/exact
	@VXS_TEST_REPEATS=all VXS_SIDE=512 VXS_COLUMNS=1000000 VXS=$B/vxs $(python) -m pytest -q -p no:cacheprovider -n auto tests/cli/test_exact.py
check-memory: all
	@VXS_EVERY_SCENE=1 VXS=$B/vxs $(python) -m pytest -q -p no:cacheprovider tests/cli/test_limits.py -k promise
check-faults: all
	@VXS_TEST_REPEATS=all VXS_KILLS=50 VXS_LARGE=1 VXS_EVERY_BIT=1 VXS=$B/vxs $(python) -m pytest -q -rs -p no:cacheprovider \
	    tests/cli/test_resume.py tests/cli/test_parts.py tests/cli/test_farm.py tests/cli/test_faults.py tests/cli/test_limits.py
check-sparse: $B/vxs $B/tests/exact/exact $B/tests/bench/sources
	@$(python) tests/exact/sparse.py --build $B $(if $(part),--part $(part))
check-cracks: $B/tests/bench/cracks
	@$<
check-sanitizers: packages
	@bad=0; $(MAKE) config=asan packages=skip check-unit || bad=1; \
	$(MAKE) config=tsan packages=skip build/tsan/vxs check-unit || bad=1; \
	VXS=build/tsan/vxs $(python) -m pytest -q -p no:cacheprovider tests/cli/test_threads.py || bad=1; exit $$bad

bench: all $(helper)
	@$(python) tests/bench/bench.py --build $B --json $(BENCH_JSON)
bench-bias: $B/tests/bench/bias
	$< --json build/bias.json
bench-flight: $B/vxs $B/tests/bench/flight
	$B/vxs scene city --triangles 800000 --blocks 22 -o build/flight.glb --force
	@for px in 16384 65536; do for pack in small fast; do \
	    $B/vxs bake build/flight.glb -o build/flight.vxs --resolution $$px --pack $$pack --quiet --force || exit 1; \
	    for threads in 0 1; do $B/tests/bench/flight build/flight.vxs --speed 50 --threads $$threads \
	        --json build/flight_$${px}_$${pack}_$$threads.json || exit 1; done; done; done
bench-large: $B/vxs $B/tests/bench/two_maps
	@$(python) tests/bench/large.py --build $B --json build/large.json $(if $(against),--against $(against))

gpu.benches := $(patsubst %,$B/tests/bench/%,gpu area smoke)
bench-gpu: $B/vxs $(gpu.benches)
	@$(python) tests/bench/gpu.py --vxs $< --gpu $B/tests/bench/gpu $(foreach o,size runs warm,$(if $($o),--$o $($o)))

# of a machine's graphics card: make bench-lights gl=egl size=1920x1080 resolution=8192 frames=200
bench-lights: $B/vxs
	@$(python) tests/bench/lights.py --vxs $< --json build/lights.json $(foreach o,gl size filter resolution frames runs,$(if $($o),--$o $($o)))

# of a machine's graphics card: make bench-volumes gl=egl size=1920x1080 rounds=31
bench-volumes bench-smoke: $B/vxs $(patsubst %,$B/tests/bench/%,volumes smoke area)
	@$(python) tests/bench/volumes.py --build $B $(foreach o,gl size resolution rounds values capsules points samples clock only plots scenes,$(if $($o),--$o "$($o)"))
bench-smoke: only := smoke

program-size: $B/vxs $B/tests/bench/programs
	@$(python) tests/bench/program_size.py --build $B
# programs that draw are known once they are compiled
gpu-kit: $(unit) $B/vxs $(gpu.benches)
	@$(python) tests/gpu/kit.py --build $B -o build/gpu-kit.tar.xz

# --- other goals -----------------------------------------------------------------------------------------------------------

format:
	clang-format -i $(wildcard $(foreach d,baker baker/* baker/*/* scenes formats runtime runtime/* tests tests/*,$d/*.c $d/*.cc $d/*.h))

clean:
	$(RM) -r build

-include $(objects:.o=.d) $(gltf.gch:.gch=.d)
