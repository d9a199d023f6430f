# The command and bake() as WebAssembly: the core without the laboratory. Included by runtime/web/web.mk.
# SPDX-License-Identifier: GPL-3.0-or-later

web.libraries += baker/web/libraries.txt
wasm.sources := $(patsubst %,$W/sources/%/.unpacked,zstd xxhash png zlib webp draco meshoptimizer jansson gmp)
wasm.libs  := $(patsubst %,$W/lib/lib%.a,zstd xxhash png zlib webp jansson meshoptimizer draco gmp)
wasm.out   := $P/baker

# files that run often are compiled for speed, those that a run calls once for size; where most of the time goes, whatever it takes
wasm.hot   := baker/columns/sparse/leaf.c baker/coding/blocks/block_node.c formats/vxs_page_encode.c
wasm.cold  := baker/command/% baker/files/% baker/scene/% baker/library/% baker/main.c baker/bake/% baker/web/% runtime/% baker/light/% \
              baker/smoke/% baker/coding/dag/% baker/coding/blocks/block_map.c formats/vxs_read% formats/vxs_write% formats/vxs_page_check.c \
              formats/vxs_page_decode.c formats/vxs_resident_check.c
wasm.speed  = $(if $(filter $(wasm.hot),$<),-O3,$(if $(filter $(wasm.cold),$<),-Os,-O2))
# CGAL's code for SSE2 is assembly
wasm.simd   = -msimd128 -mnontrapping-fptoint -msign-ext $(if $(filter baker/casters/%.cc,$<),,-msse2)
# never -DNDEBUG: CGAL checks its rounding in assertions
wasm.flags  = $(filter -I%,$(flags)) -isystem $W/include -MMD -MP -ffp-contract=off $(wasm.speed) $(wasm.simd)
wasm.cflags = -std=c11 -D_GNU_SOURCE $(warn) -Wstrict-prototypes -Wmissing-prototypes $(wasm.flags)
wasm.cxxflags = -std=c++17 $(warn) $(wasm.flags) -fwasm-exceptions -DCGAL_DISABLE_GMPXX -DCGAL_ALWAYS_ROUND_TO_NEAREST

wasm.c     := $(filter-out baker/base/system_linux.c baker/files/png_encode.c,$(bake.c)) $(format.c) $(filter-out baker/command/process/watched_files.c,$(command.c)) $(no_lab.c) $(runtime.c) $(wildcard runtime/volumes/*/area_points.c) baker/main.c baker/web/system_web.c
wasm.cc    := $(wildcard baker/casters/*.cc baker/scene/gltf/*.cc baker/command/process/*.cc)
wasm.data  := $(command.data:$B/%.o=%)
wasm.o     := $(patsubst %,$W/o/command/%.o,$(wasm.c) $(wasm.cc) $(wasm.data))
# the same with threads, for hosts that lend them
wasm.threads.o := $(patsubst %,$W/o/threads/%.o,$(wasm.c) baker/web/threads_web.c $(wasm.cc))

# a make of its own
$W/lib/.made: $(wasm.sources) baker/web/wasm_libraries.mk | $(web.tools)
	$Q$(MAKE) --no-print-directory -f baker/web/wasm_libraries.mk W=$W V=$V && touch $@
$(wasm.libs): $W/lib/.made ;

$(wasm.o) $(wasm.threads.o): | $W/lib/.made
$(wasm.o): wasm.threads := -DVXS_ONE_THREAD -DCGAL_HAS_NO_THREADS
$(wasm.threads.o): wasm.threads := -pthread
$(filter %.cc.o,$(wasm.threads.o)): wasm.threads += -include baker/web/thread_exceptions.h
define wasm.compile
$W/o/$1/%.c.o: %.c
	@echo "  emcc $$<$2"
	$$Q mkdir -p $$(@D) && emcc $$(wasm.cflags) $$(wasm.threads) -c $$< -o $$@
$W/o/$1/%.cc.o: %.cc
	@echo "  emcc $$<$2"
	$$Q mkdir -p $$(@D) && emcc $$(wasm.cxxflags) $$(wasm.threads) -c $$< -o $$@
endef
$(eval $(call wasm.compile,command))
$(eval $(call wasm.compile,threads, (threads)))
# as `ld -r -b binary` names them (baker/base/embedded.h); both labels lie in one section
$(patsubst %,$W/o/command/%.o,$(wasm.data)): $W/o/command/%.o: %
	@echo "  data $<"
	$Q mkdir -p $(@D) && n=_binary_$$(echo $(<F) | tr . _) && printf '.section .rodata.%s,"",@\n.globl %s_start\n.globl %s_end\n%s_start:\n.incbin "%s"\n%s_end:\n.size %s_start, %s_end-%s_start\n.size %s_end, 0\n' \
	    $$n $$n $$n $$n $< $$n $$n $$n $$n $$n >$@.s && emcc -c $@.s -o $@

wasm.link := emcc -Os -fwasm-exceptions -sSUPPORT_LONGJMP=wasm -sSTANDALONE_WASM -sALLOW_MEMORY_GROWTH -sMAXIMUM_MEMORY=4GB -sINITIAL_MEMORY=16MB \
             -sTOTAL_STACK=2MB -Wl,-u,calloc -sERROR_ON_UNDEFINED_SYMBOLS=0 -sWARN_ON_UNDEFINED_SYMBOLS=0
$(wasm.out)/vxs.wasm: $(wasm.o) $(wasm.libs)
	@echo "  link $@"
	$Q mkdir -p $(@D) && $(wasm.link) $(wasm.ld) -o $@ $^
# emcc knows no standalone WebAssembly with threads: its C library for threads is named here. Not checked: libraries and crt1.o are compiled
# without threads, but have neither atomics nor variables of threads
wasm.libc := -lstandalonewasm-memgrow -lstubs -lc-mt -ldlmalloc-mt -lcompiler_rt-wasm-sjlj-mt -lc++-mt-except -lc++abi-mt-except -lunwind-mt-except
$(wasm.out)/vxs-threads.wasm: $(wasm.threads.o) $(patsubst %,$W/o/command/%.o,$(wasm.data)) $(wasm.libs)
	@echo "  link $@"
	$Q mkdir -p $(@D) && $(wasm.link) -sIMPORTED_MEMORY -nodefaultlibs -Wl,--shared-memory,--no-check-features $(wasm.ld) -o $@ $^ $(wasm.libc)
wasm.mjs := $(patsubst baker/web/%,$(wasm.out)/%,$(filter-out baker/web/command.mjs,$(wildcard baker/web/*.mjs baker/web/*.d.ts)))
$(wasm.mjs): $(wasm.out)/%: baker/web/%
	$Q mkdir -p $(@D) && cp $< $@
$P/bin/vxs.mjs: baker/web/command.mjs
	$Q mkdir -p $(@D) && cp $< $@
web.files += $(wasm.out)/vxs.wasm $(wasm.out)/vxs-threads.wasm $(wasm.mjs) $P/bin/vxs.mjs

-include $(wasm.o:.o=.d) $(wasm.threads.o:.o=.d)
