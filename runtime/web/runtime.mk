# The runtime as WebAssembly: build/web/vxs/runtime. Included by web.mk.
# SPDX-License-Identifier: MIT
#
#   vxs.wasm, core.wasm      all of the runtime; open, words, constants and depth maps alone
#   vxs-base64.mjs, vxs.cjs  vxs.wasm as text; the runtime with it for require()
#   *.mjs, *.d.ts            copied from runtime/web/

include runtime/web/libraries.mk

EMCC       ?= emcc
WASM_OPT   ?= wasm-opt
web.o      := $W/o
web.out    := $P/runtime
zstd.src   := $W/sources/zstd/lib
xxhash.src := $W/sources/xxhash

web.c      := runtime/web/vxs_web.c runtime/web/exponential.c $(runtime.c)
web.zstd   := $(addprefix $(zstd.src)/,decompress/huf_decompress.c decompress/zstd_ddict.c decompress/zstd_decompress.c \
              decompress/zstd_decompress_block.c common/entropy_common.c common/error_private.c common/fse_decompress.c common/zstd_common.c common/xxhash.c)
# SIMD, i32.popcnt, conversions that saturate: what browsers have since 2021
web.cpu    := -flto -msimd128 -msse2 -D__POPCNT__=1 -mnontrapping-fptoint -mbulk-memory -msign-ext
web.flags  := -std=c11 -D_GNU_SOURCE $(web.cpu) -ffp-contract=off -DNDEBUG -DVXS_ONE_THREAD -DVXS_NO_FILES -DVXS_SMALL \
              -I. -Iformats -Iruntime -I$(zstd.src) -I$(xxhash.src) -Wall -Wextra -Wshadow -Wpointer-arith -MMD -MP
web.zflags := $(web.cpu) -DNDEBUG -DZSTD_DISABLE_ASM -DZSTD_LEGACY_SUPPORT=0 -DZSTD_STRIP_ERROR_STRINGS -DHUF_FORCE_DECOMPRESS_X1 \
              -DZSTD_FORCE_DECOMPRESS_SEQUENCES_SHORT -DZSTD_NO_INLINE -DXXH_NO_INLINE_HINTS=0 -w -MMD -MP
# Small, except for lookups and the decoder of pages; there, loops of a few rounds stay loops
web.loops  := -O2 -fno-unroll-loops -fno-vectorize -fno-slp-vectorize
web.opt     = -Oz
$(addprefix $(web.o)/runtime/,lookup.o lookup_many.o taps_many.o): web.opt = $(web.loops)
$(web.o)/formats/vxs_page_decode.o: web.opt = $(web.loops) -fno-inline-functions
# stack-first: an overflow of the stack traps
web.link   := -Oz $(web.cpu) --no-entry -sSTANDALONE_WASM -sALLOW_MEMORY_GROWTH -sINITIAL_MEMORY=1MB -sMAXIMUM_MEMORY=4GB -sTOTAL_STACK=128KB -sMALLOC=emmalloc \
              -sFILESYSTEM=0 -sERROR_ON_UNDEFINED_SYMBOLS=0 -sWARN_ON_UNDEFINED_SYMBOLS=0 -Wl,-u,calloc,--stack-first -sEXPORTED_FUNCTIONS=_malloc,_free

# functions of a few instructions are inlined, which makes the file smaller, too; emcc -Oz inlines none
web.inline := --enable-simd --enable-bulk-memory --enable-sign-ext --enable-nontrapping-float-to-int --enable-mutable-globals \
              -aimfs 8 -fimfs 1 -ocimfs 8 --inlining-optimizing -Oz --converge


web.objects := $(web.c:%.c=$(web.o)/%.o)
web.zobjects := $(web.zstd:$W/sources/%.c=$(web.o)/%.o) $(web.o)/xxhash/xxhash.o

$(web.objects): $(web.o)/%.o: %.c runtime/web/runtime.mk | $W/sources/zstd/.unpacked $W/sources/xxhash/.unpacked
	@echo "  emcc $<"
	$Q mkdir -p $(@D) && $(EMCC) $(web.flags) $(web.opt) -c $< -o $@

$W/sources/zstd/%.c: $W/sources/zstd/.unpacked ;
$W/sources/xxhash/%.c: $W/sources/xxhash/.unpacked ;
$(web.zobjects): $(web.o)/%.o: $W/sources/%.c runtime/web/runtime.mk
	@echo "  emcc $<"
	$Q mkdir -p $(@D) && $(EMCC) $(web.zflags) -Oz -c $< -o $@

# the same without lookups and streams: what is exported decides
web.core := $(web.o)/runtime/web/vxs_core.o
$(web.core): runtime/web/vxs_web.c runtime/web/runtime.mk | $W/sources/zstd/.unpacked $W/sources/xxhash/.unpacked
	@echo "  emcc $< (core)"
	$Q mkdir -p $(@D) && $(EMCC) $(web.flags) -DVXS_WEB_CORE $(web.opt) -c $< -o $@
$(web.out)/vxs.wasm: $(web.objects) $(web.zobjects)
$(web.out)/core.wasm: $(web.core) $(filter-out %/vxs_web.o,$(web.objects)) $(web.zobjects)
$(web.out)/vxs.wasm $(web.out)/core.wasm: runtime/web/runtime.mk
	@echo "  emcc $@"
	$Q mkdir -p $(@D) && $(EMCC) $(web.link) $(filter %.o,$^) -o $@.wasm && $(WASM_OPT) $(web.inline) $@.wasm -o $@ && chmod 644 $@ && $(RM) $@.wasm

web.modules := $(patsubst runtime/web/%,$(web.out)/%,$(wildcard runtime/web/*.mjs runtime/web/*.d.ts))
$(web.modules): $(web.out)/%: runtime/web/%
	$Q mkdir -p $(@D) && cp $< $@
$(web.out)/vxs-base64.mjs: $(web.out)/vxs.wasm
	$Q { echo '// SPDX-License-Identifier: MIT'; printf "export const base64 = '"; base64 -w0 $<; echo "';"; } >$@
$(web.out)/vxs.cjs: $(web.modules) $(web.out)/vxs-base64.mjs $(web.tools)
	@echo "  npm  $@"
	$Q $W/node_modules/.bin/esbuild $(web.out)/vxs-inline.mjs --bundle --format=cjs --log-level=warning --outfile=$@

# types for require(), which must not name a module
$(web.out)/%.d.cts: runtime/web/%.d.ts
	$Q mkdir -p $(@D) && sed "s,'\./core\.js','./core.cjs'," $< >$@

# of the libraries that the WebAssembly holds: their licences ask that their texts come with it
$(web.out)/LICENSES.txt: $W/sources/zstd/.unpacked $W/sources/xxhash/.unpacked
	$Q mkdir -p $(@D) && for name in zstd xxhash; do echo "$$name"; echo; cat $W/sources/$$name/LICENSE; echo; done >$@

web.runtime := $(addprefix $(web.out)/,LICENSES.txt vxs.wasm core.wasm vxs.cjs vxs-base64.mjs vxs.d.cts core.d.cts) $(web.modules)
web.files   += $(web.runtime)

-include $(web.objects:.o=.d) $(web.core:.o=.d)

# what tests compare with: answers of the C library
$B/tests/web/answers: $B/tests/web/answers.c.o $B/libvxs.a
	@echo "  link $@"
	$Q $(CC) $(opt) $(LDFLAGS) $^ $(libs) -o $@
objects += $B/tests/web/answers.c.o
check-web: $B/tests/web/answers
