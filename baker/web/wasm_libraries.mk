# Libraries that the command links as WebAssembly, from unpacked sources: a make of its own, because the lists of files are known only when
# they are unpacked. baker.mk calls it.
#   make -f baker/web/wasm_libraries.mk W=build/web
# SPDX-License-Identifier: GPL-3.0-or-later

S := $W/sources
L := $W/lib
I := $W/include
Q := $(if $(V),,@)

# what runs often is fast, what a bake calls once is small
fast  := -O2
small := -Os
flags := -I$I -msimd128 -ffp-contract=off -w

zstd   := $(wildcard $S/zstd/lib/common/*.c $S/zstd/lib/compress/*.c $S/zstd/lib/decompress/*.c)
xxhash := $S/xxhash/xxhash.c
zlib   := $(patsubst %,$S/zlib/%.c,adler32 crc32 inffast inflate inftrees zutil)
png    := $(patsubst %,$S/png/%.c,png pngerror pngget pngmem pngpread pngread pngrio pngrtran pngrutil pngset pngtrans)
webp   := $(filter-out %_enc.c %_mips32.c %_mips_dsp_r2.c %_msa.c %_neon.c %_sse2.c %_sse41.c,$(wildcard $S/webp/src/dec/*.c $S/webp/src/dsp/*.c $S/webp/src/utils/*.c))
jansson := $(wildcard $S/jansson/src/*.c)
meshoptimizer := $(patsubst %,$S/meshoptimizer/src/%.cpp,allocator indexcodec vertexcodec vertexfilter)
draco  := $(filter-out %_test.cc %_encoder.cc %_test_utils.cc %/encode.cc %/expert_encode.cc,$(wildcard $(addprefix $S/draco/src/draco/, \
              $(addsuffix /*.cc,core attributes compression compression/attributes compression/attributes/prediction_schemes compression/bit_coders \
              compression/entropy compression/mesh compression/mesh/traverser compression/point_cloud mesh metadata point_cloud))))
# the small implementation that comes with GMP: the numbers of CGAL are short. mini-mpq.c is a second part of mini-gmp.c
gmp    := $S/gmp/mini-gmp/mini-mpq.c
names  := zstd xxhash zlib png webp jansson meshoptimizer draco gmp

all: $(names:%=$L/lib%.a)

# headers: generated ones, those of libraries, and those of Debian's packages that are headers alone
system := CGAL boost nlohmann tiny_gltf.h mpfr.h jansson.h jansson_config.h
$I/.made: $(MAKEFILE_LIST)
	$Q mkdir -p $I/draco && ln -sfn $(system:%=/usr/include/%) $I/
	$Q ln -sfn $(abspath $S)/zstd/lib/*.h $(abspath $S)/xxhash/xxh*.h $(abspath $S)/zlib/z*.h $(abspath $S)/png/png*.h $(abspath $S)/webp/src/webp \
	    $(abspath $S)/meshoptimizer/src/meshoptimizer.h $I/
	$Q sed -e 's/@GMP_LIMB_BITS@/32/; s/@DEFN_LONG_LONG_LIMB@//; s/@CC@/emcc/; s/@CFLAGS@//; s/@[A-Za-z_]*@/0/' $S/gmp/gmp-h.in >$I/gmp.h
	@# its functions have the names of the large one
	$Q sed -nE 's/^#define (mp[zq]_\w+) (__gmp\w+)$$/#define \1 \2/p; s/^#define (mpn_\w+) __MPN\((\w+)\)$$/#define \1 __gmpn_\2/p' $I/gmp.h >$I/gmp_names.h
	$Q ln -sfn $(abspath $S)/draco/src/draco/* $I/draco/
	$Q sed '/WRITE.*_SUPPORTED/d' $S/png/scripts/pnglibconf.h.prebuilt >$I/pnglibconf.h
	@# without its transcoder, which no decoder needs; library and command must have the same classes
	$Q touch $I/jansson_private_config.h
	$Q sed '/TRANSCODER/d' /usr/include/draco/draco_features.h >$I/draco/draco_features.h && touch $@

objects = $(addsuffix .o,$(basename $(patsubst $S/%,$L/o/%,$($1))))
define library
$L/lib$1.a: $(call objects,$1)
	@echo "  ar   $$@"
	$Q $(RM) $$@ && emar rcs $$@ $$^
$(call objects,$1): flags += $2
endef
$(eval $(call library,zstd,$(fast) -DZSTD_DISABLE_ASM -DZSTD_LEGACY_SUPPORT=0 -DXXH_NAMESPACE=ZSTD_))
$(eval $(call library,xxhash,$(fast) -msse2))
$(eval $(call library,zlib,$(fast)))
$(eval $(call library,png,$(small) -sSUPPORT_LONGJMP=wasm))
$(eval $(call library,webp,$(small) -I$S/webp))
$(eval $(call library,jansson,$(small) -DHAVE_CONFIG_H -DHAVE_STDINT_H))
$(eval $(call library,meshoptimizer,$(small) -fno-exceptions))
$(eval $(call library,gmp,$(fast) -include $I/gmp_names.h -include $S/gmp/mini-gmp/mini-gmp.c))
$(eval $(call library,draco,$(small) -fwasm-exceptions))

$L/o/%.o: $S/%.c | $I/.made
	@echo "  emcc $<"
	$Q mkdir -p $(@D) && emcc $(flags) -c $< -o $@
$L/o/%.o: $S/%.cc | $I/.made
	@echo "  emcc $<"
	$Q mkdir -p $(@D) && emcc $(flags) -std=c++17 -c $< -o $@
$L/o/%.o: $S/%.cpp | $I/.made
	@echo "  emcc $<"
	$Q mkdir -p $(@D) && emcc $(flags) -std=c++17 -c $< -o $@
