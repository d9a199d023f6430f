# The runtime as WebAssembly: build/web/vxs/runtime. Included by web.mk.
# SPDX-License-Identifier: MIT
#
#   vxs.wasm, core.wasm    all of the runtime; open, words, constants and depth maps alone
#   *.mjs, vxs.cjs, *.d.ts copied or bundled from runtime/web/

include runtime/web/libraries.mk

EMCC       ?= emcc
web.o      := $W/o
web.out    := $P/runtime
zstd.src   := $W/sources/zstd/lib
xxhash.src := $W/sources/xxhash

# files that run for every lookup are compiled for speed, the others for size
web.fast   := runtime/lookup.c runtime/lookup_many.c runtime/taps_many.c runtime/tile_depths.c formats/vxs_page_decode.c
web.c      := runtime/web/vxs_web.c $(runtime.c)
web.zstd   := $(addprefix $(zstd.src)/,decompress/huf_decompress.c decompress/zstd_ddict.c decompress/zstd_decompress.c \
              decompress/zstd_decompress_block.c common/entropy_common.c common/error_private.c common/fse_decompress.c common/zstd_common.c common/xxhash.c)
web.flags  := -std=c11 -D_GNU_SOURCE -flto -msimd128 -msse2 -ffp-contract=off -DNDEBUG -DVXS_ONE_THREAD -I. -Iformats -Iruntime -I$(zstd.src) -I$(xxhash.src) \
              -Wall -Wextra -Wshadow -Wpointer-arith -MMD -MP
web.zflags := -flto -DNDEBUG -DZSTD_DISABLE_ASM -DZSTD_LEGACY_SUPPORT=0 -DZSTD_STRIP_ERROR_STRINGS -w -MMD -MP
web.link   := --no-entry -sSTANDALONE_WASM -sALLOW_MEMORY_GROWTH -sINITIAL_MEMORY=1MB -sMAXIMUM_MEMORY=4GB -sTOTAL_STACK=128KB -sMALLOC=emmalloc -sFILESYSTEM=0 \
              -Wl,-u,calloc -flto -sEXPORTED_FUNCTIONS=_malloc,_free

web.objects := $(web.c:%.c=$(web.o)/%.o)
web.zobjects := $(web.zstd:$W/sources/%.c=$(web.o)/%.o) $(web.o)/xxhash/xxhash.o

$(web.objects): $(web.o)/%.o: %.c | $W/sources/zstd/.unpacked $W/sources/xxhash/.unpacked
	@echo "  emcc $<"
	$Q mkdir -p $(@D) && $(EMCC) $(web.flags) $(if $(filter $(web.fast),$<),-O3,-Os) -c $< -o $@

$W/sources/zstd/%.c: $W/sources/zstd/.unpacked ;
$W/sources/xxhash/%.c: $W/sources/xxhash/.unpacked ;
$(web.zobjects): $(web.o)/%.o: $W/sources/%.c
	@echo "  emcc $<"
	$Q mkdir -p $(@D) && $(EMCC) $(web.zflags) -Os -c $< -o $@

$(web.out)/vxs.wasm: $(web.objects) $(web.zobjects) runtime/web/runtime.mk
	@echo "  emcc $@"
	$Q mkdir -p $(@D) && $(EMCC) -O3 $(web.link) $(web.objects) $(web.zobjects) -o $@

web.modules := $(patsubst runtime/web/%,$(web.out)/%,$(wildcard runtime/web/*.mjs runtime/web/*.d.ts))
$(web.modules): $(web.out)/%: runtime/web/%
	$Q mkdir -p $(@D) && cp $< $@

web.runtime := $(web.out)/vxs.wasm $(web.modules)
web.files   += $(web.runtime)

-include $(web.objects:.o=.d)
