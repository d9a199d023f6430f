# The headers of a lookup in every dialect that docs/runtime.md names: each shader of tests/shaders compiles without a warning, the
# constants of a light lie where runtime/vxs.h says, and missing definitions of the includer are named.
# tests/unit/test_shaders.c runs the shaders.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import re
import shutil
import subprocess

import pytest

from conftest import ROOT

HEADERS = ("vxs_lookup.h", "vxs_lookup_blocks.h", "vxs_space.h")
SHADERS = sorted(path for path in (ROOT / "tests" / "shaders").iterdir() if path.suffix != ".wgsl")  # test_wgsl.py
WORDS = "#version 430 core\nlayout(std430, binding = 0) buffer shadow_words { uint words[]; };\n"
WORD = "#define vxs_word(dag, i) words[(dag) + (i)]\n"
COMPUTE = "layout(local_size_x = 1) in;\n"


def header(name):
    return (ROOT / "formats" / name).read_text()


@pytest.fixture
def glslang(tmp_path):
    """glslang(text, name, *options): what the compiler says of a text, all of which is one string as a shader's is."""
    if not shutil.which("glslangValidator"):
        pytest.skip("no glslangValidator: package glslang-tools")

    def run(text, name, *options, good=True):
        (tmp_path / name).write_text(text)
        done = subprocess.run(["glslangValidator", *options, name], cwd=tmp_path, capture_output=True, text=True)
        assert (done.returncode == 0) == good, done.stdout
        assert not good or "WARNING" not in done.stdout, done.stdout
        return done.stdout

    return run


def with_headers(text, names=HEADERS):
    for name in names:
        assert text.count(f'#include "{name}"\n') == 1
        text = text.replace(f'#include "{name}"\n', header(name))
    return text


def options_of(name):
    if name.endswith(".hlsl"):  # whose includes work
        return ["-D", "-V", "-S", "frag", "-e", "main", f"-I{ROOT / 'formats'}", "-o", "shader.spv"]
    return ["-V", "-o", "shader.spv"] if "vulkan" in name else []


def test_dialects():
    versions = {path.name: path.read_text().partition("\n")[0] for path in SHADERS}
    assert versions == {"lit.hlsl": "#define VXS_HLSL", "lit_300es.frag": "#version 300 es", "lit_310es.frag": "#version 310 es",
                        "lit_330.frag": "#version 330 core", "lit_430.frag": "#version 430 core", "lit_vulkan.frag": "#version 450"}


@pytest.mark.parametrize("shader", SHADERS, ids=lambda path: path.name)
def test_shader_compiles(glslang, shader):
    text = shader.read_text()
    glslang(text if shader.suffix == ".hlsl" else with_headers(text), shader.name, *options_of(shader.name))


@pytest.mark.parametrize("pcf", ["vxs_box(1)", "vxs_box(9)", "vxs_smooth(4)"])
@pytest.mark.parametrize("coding", ["any", "dag", "blocks"])
def test_spirv_is_valid(glslang, tmp_path, coding, pcf):
    """Of each coding and family of filters, with the code for others left out."""
    if not shutil.which("spirv-val"):
        pytest.skip("no spirv-val: package spirv-tools")
    width, only = re.search(r"\d+", pcf)[0], {"any": "", "dag": "#define VXS_ONLY_CODING 1\n", "blocks": "#define VXS_ONLY_CODING 2\n"}
    text = (ROOT / "tests" / "shaders" / "lit_vulkan.frag").read_text()
    assert text.count("vxs_box(9)") == 1
    text = text.replace("vxs_box(9)", pcf).replace("#version 450\n", f"#version 450\n{only[coding]}#define VXS_ONLY_WIDTH {width}\n"
                                                   f"#define VXS_ONLY_SMOOTH {int('smooth' in pcf)}\n")
    names = HEADERS
    if coding == "dag":
        text, names = text.replace('#include "vxs_lookup_blocks.h"\n', ""), ("vxs_lookup.h", "vxs_space.h")
    glslang(with_headers(text, names), "lit_vulkan.frag", *options_of("lit_vulkan.frag"))
    done = subprocess.run(["spirv-val", "--target-env", "vulkan1.0", "shader.spv"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("shader", SHADERS, ids=lambda path: path.name)
def test_shader_calls_every_function(glslang, shader):
    """What a shader does not call is compiled, too, but not what a call of it needs."""
    text = shader.read_text()
    vec = ("int3", "float3") if shader.suffix == ".hlsl" else ("ivec3", "vec3")
    body = ("{%s voxel; %s p; vxs_ws_from_voxel(light, 5, position_ws, p);"
            " int map = vxs_voxel_from_ws(light, p, normal_ws, vxs_box(17), voxel);"
            " float a = vxs_lit_at_voxel(light.first_word, light, map, voxel, vxs_smooth(1)); " % vec)
    call = re.search(r"(return|lit =) vxs_lit\(.*\);", text)
    text = text.replace(call[0], f"{body} {call[0].rstrip(';')} + a; }}")
    glslang(text if shader.suffix == ".hlsl" else with_headers(text), shader.name, *options_of(shader.name))


@pytest.mark.parametrize("shader", SHADERS, ids=lambda path: path.name)
def test_shader_of_dags_alone(glslang, shader):
    text = shader.read_text().replace('#include "vxs_lookup_blocks.h"\n', "")
    glslang(text if shader.suffix == ".hlsl" else with_headers(text, ("vxs_lookup.h", "vxs_space.h")), shader.name, *options_of(shader.name))


@pytest.mark.parametrize("shader", SHADERS, ids=lambda path: path.name)
def test_shader_asks_for_smoke(glslang, shader):
    """What is lit, times what smoke leaves of it."""
    text = shader.read_text().replace('#include "vxs_space.h"\n', '#include "vxs_space.h"\n#include "vxs_smoke.h"\n')
    call = re.search(r"(return|lit =) vxs_lit\(.*\);", text)
    text = text.replace(call[0], f"{call[0].rstrip(';')} * vxs_smoke_left(9u, light, position_ws);")
    glslang(text if shader.suffix == ".hlsl" else with_headers(text, (*HEADERS, "vxs_smoke.h")), shader.name, *options_of(shader.name))


def test_light_in_the_air_in_hlsl(glslang):
    """The headers of the law of light and of airlight say that they are HLSL, too; GLSL is run by unit tests."""
    text = (ROOT / "tests" / "shaders" / "lit.hlsl").read_text().partition("cbuffer")[0] + """#include "vxs_air_light.h"
#include "vxs_air.h"
#include "vxs_air_path.h"
float3 main(float3 at : POSITION_WS, float3 eye : EYE, float3 direction : DIRECTION) : SV_Target
{
    vxs_medium    medium = {float3(0.1, 0.1, 0.1), float3(0.2, 0.2, 0.2), 0.3};
    vxs_air_light lamp   = {2u, float3(0, 6, 0), float3(0, -1, 0), 0.8, 0.7, 0.01, 7.0};
    float3        to_light, reaches, air;
    vxs_air_reaches(medium, lamp, at, 1e30, to_light, reaches);
    float2        in_fog;
    vxs_air_path  path = vxs_air_path_of(lamp, eye, direction, 20.0, 1e30, in_fog);
    vxs_air_lit(medium, path, path.begin, vxs_air_seen_to(medium, path, 12.0), air);
    return reaches + air;
}
"""
    glslang(text, "air.hlsl", *options_of("air.hlsl"), f"-I{ROOT / 'runtime' / 'volumes'}")


def test_fog_of_the_guide(glslang):
    """The listing of docs/guide-fog.md compiles as it stands, each header a string."""
    (text,) = re.findall(r"^```glsl\n(.*?)^```", (ROOT / "docs" / "guide-fog.md").read_text(), re.MULTILINE | re.DOTALL)
    for name in re.findall(r'^#include "(\S+)"$', text, re.MULTILINE):
        folder = next(f for f in ("formats", "runtime/volumes") if (ROOT / f / name).is_file())
        text = text.replace(f'#include "{name}"\n', (ROOT / folder / name).read_text())
    glslang(text, "fog.frag")


def test_blocks_headers_alone(glslang):
    """For a shader that knows its voxels."""
    glslang(WORDS + COMPUTE + WORD + header("vxs_lookup.h") + header("vxs_lookup_blocks.h") +
            "void main() { words[0] = vxs_blocks_shadow(1u, 0u, 8u, 5u, 6u, 7u) + vxs_blocks_shadow_count(1u, 5u, 18u, -3, 6, 7u, 9); }\n",
            "blocks.comp")


def test_lookup_header_alone(glslang):
    """For a shader that knows its voxels."""
    glslang(WORDS + COMPUTE + WORD + header("vxs_lookup.h") +
            "void main() { words[0] = vxs_shadow_count(1u, vxs_face_root(1u, 3u), 8u, 5, 6, 7u, 9)\n"
            "    + vxs_shadow(1u, 0u, 8u, 5u, 6u, 7u); }\n", "lookup.comp")


WALK = """void main() {
    vxs_light_constants light;
    light.levels = 5u;
    vxs_walk w = vxs_walk_of(light, vec3(1.0), vec3(0.0, 1.0, 0.0), 0.0, 9.0);
    vxs_span span;
    while (vxs_walk_next(3u, light, w, span) != 0 || vxs_walk_next_lit(3u, light, w, span) != 0) words[0] += uint(span.state);
}
"""


@pytest.mark.parametrize("version", ["#version 430 core", "#version 310 es"])
def test_intervals(glslang, version):
    """A walk along a ray, behind the headers of a lookup."""
    texts = [header(name) for name in (*HEADERS, "vxs_depths.h", "vxs_intervals.h")]
    glslang(WORDS.replace("#version 430 core", version) + COMPUTE + WORD + "".join(texts) + WALK, "walk.comp")


CURVE = """void main() {
    vxs_curve curve = vxs_curve_empty();
    vxs_curve_insert(curve, 8, 1.0, 2.0, 0.5);
    vxs_curve_pad(curve, 8);
    words[0] = uint(curve.left[7] + vxs_curve_at(curve, 3.0, 0) + vxs_curve_read(0u, 16, 8, 3.0, 1));
}
"""


@pytest.mark.parametrize("version", ["#version 430 core", "#version 310 es"])
def test_curves(glslang, version):
    """Of smoke, behind the headers of a lookup, with fewer nodes than there could be."""
    number = "#define VXS_CURVE_MOST 8\n#define vxs_curve_number(curves, i) uintBitsToFloat(words[(curves) + uint(i)])\n"
    glslang(WORDS.replace("#version 430 core", version) + COMPUTE + WORD + "".join(map(header, HEADERS)) + number +
            (ROOT / "runtime" / "volumes" / "vxs_curve.h").read_text() + CURVE, "curve.comp")


def test_word_has_to_be_defined(glslang):
    said = glslang(WORDS + header("vxs_lookup.h") + "void main() {}\n", "none.frag", good=False)
    assert "vxs_word is not defined" in said


def test_popcount_is_the_includers(glslang):
    said = glslang(WORDS + WORD + "#define vxs_popcount(x) bits_of(x)\n" + header("vxs_lookup.h") + "void main() {}\n", "bits.frag",
                   good=False)
    assert "bits_of" in said


# --- the constants of a light -----------------------------------------------------------------------------------------------------


def offsets_in_c():
    text = (ROOT / "runtime" / "vxs.h").read_text()
    struct = re.search(r"typedef struct vxs_light_constants \{(.*?)\} vxs_light_constants; +/\* (\d+) bytes", text, re.DOTALL)
    rows = re.findall(r"^ +(?:\w+\s+)?(\w+)(?:\[(\d+)\])?; +/\* byte +(\d+)", struct[1], re.MULTILINE)
    return {name: int(byte) for name, _, byte in rows}, int(struct[2])


def reflected(said, prefix):
    return {name: int(offset) for name, offset in re.findall(rf"^{re.escape(prefix)}(\w+): offset (\d+)", said, re.MULTILINE)}


def test_constants_lie_as_in_c(glslang):
    wanted, size = offsets_in_c()
    assert len(wanted) == 13 and size == 96
    fields = " + ".join(f"float(c.{name}{'[0].x' if name == 'ls_from_ws' else ''})" for name in wanted)
    said = glslang(WORDS + COMPUTE + WORD + header("vxs_lookup.h") + header("vxs_space.h") +
                   "layout(std140, binding = 0) uniform block { vxs_light_constants one; vxs_light_constants some[3]; };\n"
                   "layout(std430, binding = 1) buffer lights { vxs_light_constants all[]; };\n"
                   f"float sum(vxs_light_constants c) {{ return {fields}; }}\n"
                   "void main() { words[0] = uint(sum(one) + sum(some[1]) + sum(all[1])); }\n", "layout.comp", "-l", "-q")
    assert reflected(said, "one.") == reflected(said, "all.") == wanted
    assert reflected(said, "some.") == {name: size + offset for name, offset in wanted.items()}
    for array in ("some", "all"):
        assert re.search(rf"^{array}\.first_word: .*topLevelArrayStride {size}$", said, re.MULTILINE)


# --- the same text in C and C++ with the includer's macros -------------------------------------------------------------------------

FLOATS = """
#define vxs_real      float
#define VXS_REAL_MIN  1e-30f
#define VXS_LIGHT     const vxs_light_constants *
#define VXS_WORDS     uint32_t
#define vxs_popcount(x) bits_of(x)
#define vxs_word(dag, i) words[(dag) + (i)]
#include <stdint.h>
static const uint32_t words[5] = {0, 0x5ee0, 0, 0, 0};
static inline uint32_t bits_of(uint32_t x) { uint32_t n = 0; for (; x; x &= x - 1) n++; return n; }
#include "runtime/vxs.h"
#include "formats/vxs_space.h"
int main(void)
{
    vxs_light_constants light = {{0}, 1, 1, 0, 0, 0, VXS_LIGHT_KIND_DIRECTIONAL, 0, 3, 1, VXS_CODING_DAG, 0, 0};
    const float normal[3] = {0, 0, 0};
    float point[3] = {2.5f, 4.5f, 7.5f};
    int n;
    for (n = 0; n < 3; n++) light.ls_from_ws[5 * n] = 1;
    if (vxs_lit(light.first_word, &light, point, normal, vxs_box(1)) != 0) return 1;
    point[2] = -1;
    if (vxs_lit(light.first_word, &light, point, normal, vxs_box(1)) != 1) return 2;
    point[0] = 9;
    return vxs_lit(light.first_word, &light, point, normal, vxs_box(9)) == VXS_OUTSIDE ? 0 : 3;
}
"""


@pytest.mark.parametrize("language, standard", [("c", "c99"), ("c++", "c++11")])
def test_macros_of_the_includer(language, standard, tmp_path):
    """A lookup in float on the constants of a shader, with words and bits of the includer's own."""
    compiler = os.environ.get("CC", "cc") if language == "c" else os.environ.get("CXX", "c++")
    (tmp_path / "floats").write_text(FLOATS)
    subprocess.run([*compiler.split(), "-x", language, f"-std={standard}", "-Wall", "-Wextra", "-Werror", "-pedantic-errors", f"-I{ROOT}",
                    f"-I{ROOT / 'formats'}", f"-I{ROOT / 'runtime'}", tmp_path / "floats", "-o", tmp_path / "run", "-lm"], check=True)
    assert subprocess.run([tmp_path / "run"]).returncode == 0


WALKED = """
#include "formats/vxs_intervals.h"
int main(void)
{
    static const uint32_t words[14] = {0, 0, 8, 0, 0, 0, 0, 0, 0x80000003, 0, 0, 0, 0, 0};
    const double from[3] = {1, 1, -5}, along[3] = {0, 0, 1};
    vxs_light light = {{0}, VXS_LIGHT_KIND_DIRECTIONAL, 0, 3, VXS_CODING_BLOCKS, {0}, 1, 1, {0, 0, 1}, 0, 0, 0};
    vxs_walk w;
    vxs_span span;
    int n;
    for (n = 0; n < 3; n++) light.ls_from_ws[5 * n] = 1;
    w = vxs_walk_of(&light, from, along, 0, 20);
    if (!vxs_walk_next(words, &light, &w, &span) || span.state != VXS_SPAN_LIT || span.begin != 0 || span.end != 8) return 1;
    if (!vxs_walk_next(words, &light, &w, &span) || span.state != VXS_SPAN_SHADOW || span.end != 20) return 2;
    return vxs_walk_next(words, &light, &w, &span);
}
"""


CURVED = """
#include "runtime/volumes/vxs_curve.h"
int main(void)
{
    vxs_curve curve = vxs_curve_empty();
    const float stored[8] = {1, 1, 2, 0.5f, 1e30f, 0.5f, 1e30f, 0.5f};
    vxs_curve_insert(&curve, 4, 1, 2, 0.875);
    vxs_curve_pad(&curve, 4);
    if (curve.count != 2 || curve.left[3] != 0.875 || vxs_curve_at(&curve, 1.5, 0) != 0.9375) return 1;
    return vxs_curve_read(stored, 0, 4, 1.5, 0) == 0.75 && vxs_curve_read(stored, 0, 4, 9, 1) == 0.5 ? 0 : 2;
}
"""


@pytest.mark.parametrize("text", [WALKED, CURVED], ids=["intervals", "curves"])
@pytest.mark.parametrize("language, standard", [("c", "c99"), ("c++", "c++11")])
def test_headers_in_c(language, standard, text, tmp_path):
    compiler = os.environ.get("CC", "cc") if language == "c" else os.environ.get("CXX", "c++")
    (tmp_path / "walked").write_text(text)
    subprocess.run([*compiler.split(), "-x", language, f"-std={standard}", "-Wall", "-Wextra", "-Werror", "-pedantic-errors", f"-I{ROOT}",
                    f"-I{ROOT / 'formats'}", tmp_path / "walked", "-o", tmp_path / "run", "-lm"], check=True)
    assert subprocess.run([tmp_path / "run"]).returncode == 0


BLOCKS = """
INCLUDER
#include <stdint.h>
static const uint32_t words[14] = {0, 0, 8, 0, 0, 0, 0, 0, 0x80000003, 0, 0, 0, 0, 0};
#include "formats/vxs_lookup_blocks.h"
int main(void)
{
    if (vxs_blocks_shadow(LIGHT, 0, 3, 1, 1, 2) != 0 || vxs_blocks_shadow(LIGHT, 0, 3, 1, 1, 3) != 1) return 1;
    return vxs_blocks_shadow_count(LIGHT, 0, 3, 0, 7, 5, 9) == 25 ? 0 : 2;
}
"""
MEMORY = "#define LIGHT words"
INDEXED = """#define LIGHT 0
#define VXS_WORDS uint32_t
#define vxs_word(light, i) words[(light) + (i)]"""


@pytest.mark.parametrize("includer", [MEMORY, MEMORY + "\n#define VXS_SCALAR", INDEXED], ids=["memory", "scalar", "indexed"])
@pytest.mark.parametrize("language, standard", [("c", "c99"), ("c++", "c++11")])
def test_blocks_in_c(language, standard, includer, tmp_path):
    """By vectors, word by word, and with words that are fetched by the includer's own macro."""
    compiler = os.environ.get("CC", "cc") if language == "c" else os.environ.get("CXX", "c++")
    (tmp_path / "blocks").write_text(BLOCKS.replace("INCLUDER", includer))
    subprocess.run([*compiler.split(), "-x", language, f"-std={standard}", "-Wall", "-Wextra", "-Werror", "-pedantic-errors", f"-I{ROOT}",
                    tmp_path / "blocks", "-o", tmp_path / "run"], check=True)
    assert subprocess.run([tmp_path / "run"]).returncode == 0


# --- the same answer of real files ---------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.long  # of a file of tests/golden the unit program queries itself
def test_same_answer_of_files(vxs, vxs_path, scenes, tmp_path):
    """A sun and spot lights, in both codings: C, storage buffer and texture to the bit (tests/unit/test_gl.c; VXS_POINTS of each)."""
    program = vxs_path.parent / "tests" / "unit" / "test_gl"
    if not program.is_file():
        pytest.skip(f"no {program}")
    vxs("scene", "city", "--spots", 9, "--triangles", 5000, "-o", tmp_path / "city.glb")
    bakes = [("city.vxs", tmp_path / "city.glb", "--resolution", 1024), ("dag.vxs", tmp_path / "city.glb", "--resolution", 512, "--coding", "dag"),
             ("sponza.vxs", scenes / "real" / "sponza.glb", "--sun", "0.2,-1,0.25", "--resolution", 2048)]
    for name, scene, *options in bakes:
        vxs("bake", scene, "-o", tmp_path / name, *options)
    files = [str(tmp_path / name) for name, *_ in bakes]
    env = os.environ | {"VXS_ASSETS": ":".join(files), "VXS_POINTS": os.environ.get("VXS_POINTS", "1e5")}
    done = subprocess.run([program], cwd=ROOT, env=env, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert all(re.search(rf"^{re.escape(name)}: \d+ points by each storage", done.stdout, re.MULTILINE) for name in files)
