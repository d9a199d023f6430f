# The listings of docs/engine-*.md: compiled, and run where a compiler and what they need is here; their answers are those of vxs query.
# SPDX-License-Identifier: GPL-3.0-or-later
import os
import random
import shutil
import subprocess

import pytest

import small_scene
from conftest import ROOT
from small_scene import NOON
from test_docs import listings

HEADERS = [ROOT / "formats" / name for name in ("vxs_lookup.h", "vxs_lookup_blocks.h", "vxs_space.h")]
INCLUDES = [f"-I{ROOT / folder}" for folder in ("formats", "runtime")]


def page(name, language):
    return listings(language, ROOT / "docs" / f"engine-{name}.md")


@pytest.fixture(scope="module")
def folder(vxs, tmp_path_factory):
    """A level of a sun, points in glTF's world with normals, and answers of smooth(9)."""
    at = tmp_path_factory.mktemp("engines")
    small_scene.write(at / "a.gltf", lights=(("sun", "directional", NOON),))
    vxs("bake", at / "a.gltf", "-o", at / "level.vxs", "--resolution", 512)
    dice = random.Random(1)
    points = [[dice.uniform(-2, 2) for _ in range(3)] + [dice.gauss(0, 1) for _ in range(3)] for _ in range(1000)]
    lines = "".join(" ".join(map(repr, row)) + "\n" for row in points)
    at.joinpath("answers").write_text(vxs("query", at / "level.vxs", "--smooth", 9, input=lines).stdout)
    return at, points


def shared_library(vxs_path):
    library = vxs_path.parent / "libvxs.so"
    if vxs_path.parent.name in ("asan", "tsan") or not library.exists():
        pytest.skip("no libvxs.so, or one that needs a sanitizer")
    return library


def answers_alike(folder, printed, tolerance):
    wanted = [-1 if word == "out" else float(word) for word in (folder / "answers").read_text().split()]
    assert len(wanted) == 1000 and len(set(wanted)) > 20 and list(map(float, printed.split())) == pytest.approx(wanted, abs=tolerance)


def test_unity_binding(vxs_path, folder, tmp_path):
    if not shutil.which("mcs") or not shutil.which("mono"):
        pytest.skip("no mono: packages mono-mcs, mono-runtime")
    (at, points), (binding,) = folder, page("unity", "csharp")
    binding = binding.replace("new Filter { WidthPx = widthPx }", "new Filter { WidthPx = widthPx, IsSmooth = 1 }")  # the answers' filter
    (tmp_path / "a.cs").write_text(binding + """
static class Program {
    static void Main(string[] args) {
        System.Threading.Thread.CurrentThread.CurrentCulture = System.Globalization.CultureInfo.InvariantCulture;
        var level = new VxsLevel(System.IO.File.ReadAllBytes(args[0]));
        IntPtr sun = level.Light("sun");
        string line;
        while ((line = Console.ReadLine()) != null) {
            var n = Array.ConvertAll(line.Split(' '), double.Parse);
            Console.WriteLine(VxsLevel.Lookup(sun, n[0], n[1], n[2], n[3], n[4], n[5], 9));
        }
        var c = level.ShaderConstants(sun);
        Console.Error.WriteLine(string.Join(" ", c.M00, c.M01, c.M02, c.M03, c.TexelMetres, c.Kind, c.Levels, c.Coding, level.Words(sun).Length));
        level.Dispose();
        try { new VxsLevel(new byte[5]); } catch (InvalidOperationException e) { Console.Error.WriteLine(e.Message); }
    }
}
""")
    subprocess.run(["mcs", "-out:a.exe", "a.cs"], cwd=tmp_path, check=True)
    lines = "".join(" ".join(map(repr, [-row[0], *row[1:3], -row[3], *row[4:]])) + "\n" for row in points)
    done = subprocess.run(["mono", "a.exe", at / "level.vxs"], cwd=tmp_path, input=lines, capture_output=True, text=True,
                          env=os.environ | {"LD_LIBRARY_PATH": str(shared_library(vxs_path).parent)})
    assert done.returncode == 0, done.stderr
    answers_alike(at, done.stdout, 1e-6)
    constants, error = done.stderr.splitlines()
    assert constants.split()[5:8] == ["1", "9", "2"] and int(constants.split()[8]) > 8 and error.startswith("no shadows: ")


def test_unreal_light(vxs, vxs_path, folder, tmp_path):
    (at, points), (light,) = folder, page("unreal", "cpp")
    (tmp_path / "a.cc").write_text(light + """
#include <cstdio>
int main(int, char** args) {
    vxs_asset* asset = nullptr;
    if (vxs_asset_open_file(&asset, args[1], nullptr) != VXS_OK) return 1;
    const FVxsLight sun{vxs_asset_light(asset, 0)};
    double p[3], n[3];
    while (std::scanf("%lf %lf %lf %lf %lf %lf", p, p + 1, p + 2, n, n + 1, n + 2) == 6) std::printf("%.9g\\n", sun.Lookup(p, n));
    const double origin[3] = {0, 0, 0};
    const vxs_light_constants c = sun.Constants(origin);
    FILE* out = std::fopen(args[2], "wb");
    std::fwrite(&c, sizeof c, 1, out);
    std::fwrite(sun.Words().data(), 4, sun.Words().size(), out);
    std::fclose(out);
    vxs_asset_close(asset);
}
""")
    library = shared_library(vxs_path).with_name("libvxs.a")
    subprocess.run(["g++", "-std=c++17", "-Wall", "-Wextra", "-Werror", *INCLUDES, "a.cc", library, "-lzstd", "-lxxhash", "-pthread", "-o", "a"], cwd=tmp_path, check=True)
    lines = "".join(" ".join(map(repr, [100 * row[0], 100 * row[2], 100 * row[1], row[3], row[5], row[4]])) + "\n" for row in points)
    done = subprocess.run([tmp_path / "a", at / "level.vxs", tmp_path / "out"], input=lines, capture_output=True, text=True, check=True)
    answers_alike(at, done.stdout, 2e-3)  # a point that is scaled and scaled back may lie in the neighbouring 1/256 texel
    vxs("export", at / "level.vxs", "-o", tmp_path / "export", "--axes", "unreal")
    assert (tmp_path / "out").read_bytes() == (tmp_path / "export" / "lights.bin").read_bytes() + (tmp_path / "export" / "words.bin").read_bytes()


@pytest.fixture(scope="module")
def glslang(tmp_path_factory):
    if not shutil.which("glslangValidator"):
        pytest.skip("no glslangValidator: package glslang-tools")

    def run(text, name, *options):
        at = tmp_path_factory.mktemp("shader") / name
        at.write_text(text)
        done = subprocess.run(["glslangValidator", *options, at], capture_output=True, text=True, cwd=at.parent)
        assert done.returncode == 0, done.stdout

    return run


MAIN = {
    "unity": "float main(float3 p : P, float3 n : N) : SV_Target { return BakedShadow(p, n); }\n",
    "unity texture": "float main(float3 p : P, float3 n : N) : SV_Target { return vxs_lit(vxs_light.first_word, vxs_light, p, n, vxs_box(9)); }\n",
    "unreal": "float main(float3 p : P, float3 n : N) : SV_Target { return VxsShadow(3u, p, n); }\n",
}


@pytest.mark.parametrize("name", MAIN)
def test_hlsl(glslang, name):
    text = page(name.split()[0], "hlsl")[1 if "texture" in name else 0]
    glslang(text + MAIN[name], "a.frag", "-D", "-V", "-e", "main", "--auto-map-bindings", "--auto-map-locations", INCLUDES[0])


@pytest.mark.parametrize("number", [0, 1, 2], ids=["deferred", "forward", "cascades"])
@pytest.mark.parametrize("version", [330, 430])
def test_glsl(glslang, number, version):
    words = {330: "uniform usampler2D words;\n#define vxs_word(dag, i) texelFetch(words, ivec2(int((dag) + (i)) & 2047, int((dag) + (i)) >> 11), 0).x\n",
             430: "layout(std430, binding = 0) readonly buffer shadow_words { uint words[]; };\n#define vxs_word(dag, i) words[(dag) + (i)]\n"}[version]
    text = page("renderers", "glsl")[number]
    assert len(page("renderers", "glsl")) == 3
    glslang(f"#version {version} core\n{words}" + "".join(path.read_text() for path in HEADERS) + text, "a.frag")


def test_wgsl_is_that_of_the_tests():
    """Which tests/cli/test_wgsl.py compiles and runs, but for its filter."""
    (text,) = page("bevy", "wgsl")
    assert text == (ROOT / "tests" / "shaders" / "lit.wgsl").read_text().replace("vxs_box(9)", "vxs_smooth(9)")


@pytest.mark.long
def test_rust(vxs, folder, tmp_path):
    """Tests of the crates, the listing of the page, and an example beside vxs query."""
    if not shutil.which("cargo"):
        pytest.skip("no cargo")
    env = os.environ | {"CARGO_TARGET_DIR": str(ROOT / "build" / "rust")}
    subprocess.run(["make", "-C", ROOT, "packages=skip", "amalgamation"], check=True, capture_output=True)
    rust, (listing,) = ROOT / "runtime" / "rust", page("bevy", "rust")
    done = subprocess.run(["cargo", "test", "-q"], cwd=rust, env=env, capture_output=True, text=True)
    if "failed to download" in done.stderr or "Could not resolve host" in done.stderr:
        pytest.skip("no crates.io")
    assert done.returncode == 0, done.stdout + done.stderr
    (tmp_path / "src").mkdir()
    (tmp_path / "Cargo.toml").write_text(f'[package]\nname = "a"\nversion = "0.1.0"\nedition = "2021"\n[dependencies]\nvxs = {{ path = "{rust / "vxs"}" }}\n[workspace]\n')
    (tmp_path / "src" / "main.rs").write_text("fn main() -> Result<(), Box<dyn std::error::Error>> {\n" + listing +
                                              'println!("{lit} {} {}", words.len() - 4, constants.first_word);\nOk(())\n}\n')
    shutil.copy(folder[0] / "level.vxs", tmp_path)
    said = subprocess.run(["cargo", "run", "-q"], cwd=tmp_path, env=env, capture_output=True, text=True)
    assert said.returncode == 0, said.stderr
    assert said.stdout.split()[0] == vxs("query", tmp_path / "level.vxs", "--smooth", 9, input="0.5 0 0.5 0 1 0\n").stdout.split()[0]
    lines = "".join(" ".join(map(repr, row)) + "\n" for row in folder[1])
    said = subprocess.run(["cargo", "run", "-q", "-p", "vxs", "--example", "query", "--", tmp_path / "level.vxs"], cwd=rust, env=env, input=lines, capture_output=True, text=True)
    wanted = vxs("query", tmp_path / "level.vxs", "--filter", 9, input=lines).stdout.split()
    assert [a == w or abs(float(a) - float(w)) < 1e-6 for a, w in zip(said.stdout.split(), wanted, strict=True)] == [True] * 1000


@pytest.mark.long
def test_rust_draws_a_frame(vxs, tmp_path):
    """By wgpu on the processor: each pixel has the answer of the processor, but for where float rounding decides."""
    if not shutil.which("cargo") or not shutil.which("naga"):
        pytest.skip("no cargo" if not shutil.which("cargo") else "no naga: cargo install naga-cli")
    subprocess.run(["make", "-C", ROOT, "packages=skip", "amalgamation", "wgsl"], check=True, capture_output=True)
    vxs("scene", "city", "--triangles", 20000, "-o", tmp_path / "city.glb")
    vxs("bake", tmp_path / "city.glb", "-o", tmp_path / "level.vxs", "--resolution", 2048)
    env = os.environ | {"CARGO_TARGET_DIR": str(ROOT / "build" / "rust")}
    done = subprocess.run(["cargo", "run", "-q", "--manifest-path", ROOT / "runtime" / "rust" / "Cargo.toml", "-p", "vxs-frame", "--", "level.vxs",
                           ROOT / "build" / "release" / "vxs_lookup.wgsl"], cwd=tmp_path, env=env, capture_output=True, text=True)
    if "failed to download" in done.stderr or "Could not resolve host" in done.stderr:
        pytest.skip("no crates.io")
    assert done.returncode == 0, done.stderr
    same, total = (int(word) for word in done.stdout.splitlines()[-1].split() if word.isdigit())
    assert total == 65536 and same >= 0.999 * total and len(set((tmp_path / "frame.pgm").read_bytes()[15:])) > 10


# Ten minutes to a lit frame -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    at = tmp_path_factory.mktemp("frames")
    vxs("scene", "city", "--triangles", 10000, "-o", at / "level.glb")
    vxs("bake", at / "level.glb", "-o", at / "level.vxs")
    (program,) = listings("c", ROOT / "docs" / "engines.md")
    (at / "frame.c").write_text(program)
    return at


def frame(at):
    data = (at / "frame.pgm").read_bytes()
    (at / "frame.pgm").unlink()
    assert data.startswith(b"P5 256 256 255\n") and len(data) == 15 + 256 * 256
    return data[15:]


def by_two_files(at):
    subprocess.run(["make", "-s", "-C", ROOT, "packages=skip", "amalgamation"], check=True, capture_output=True)
    sources = ROOT / "build" / "amalgamation"
    zstd = [] if (sources / "zstddeclib.c").exists() else ["-DVXS_SYSTEM_ZSTD", "-lzstd"]
    subprocess.run(["cc", "-O1", f"-I{sources}", "frame.c", sources / "vxs.c", *zstd, "-lm", "-pthread", "-o", "frame"], cwd=at, check=True)
    with open(at / "frame.pgm", "wb") as out:
        subprocess.run([at / "frame", "level.vxs"], cwd=at, stdout=out, check=True)


def test_frames_are_alike(vxs, vxs_path, city, tmp_path):
    """By two files and by Python they are equal; by a depth map, whose one tap has hard edges, nearly."""
    numpy = pytest.importorskip("numpy", reason="no numpy: package python3-numpy")
    by_two_files(city)
    wanted = numpy.frombuffer(frame(city), numpy.uint8).astype(int)
    assert 0.2 < wanted.mean() / 255 < 0.95
    depths, module = listings("python", ROOT / "docs" / "engines.md")
    vxs("export", city / "level.vxs", "-o", city / "exported", "--depth", 4096, "--format", "raw")
    env = os.environ | {"PYTHONPATH": str(ROOT / "runtime" / "python"), "VXS_LIBRARY": str(shared_library(vxs_path))}
    for listing, tolerance in ((depths, 0.06), (module, 0)):
        subprocess.run(["/usr/bin/python3", "-c", listing], cwd=city, env=env, check=True)
        assert abs(numpy.frombuffer(frame(city), numpy.uint8).astype(int) - wanted).mean() / 255 <= tolerance


@pytest.mark.long
def test_frame_by_cmake(city, tmp_path):
    if not shutil.which("cmake"):
        pytest.skip("no cmake")
    by_two_files(city)
    wanted = frame(city)
    (text,) = listings("cmake", ROOT / "docs" / "engines.md")
    (city / "CMakeLists.txt").write_text(text)
    (city / "vxs").symlink_to(ROOT)
    subprocess.run("cmake -B made && cmake --build made && made/frame level.vxs >frame.pgm", shell=True, cwd=city, check=True, capture_output=True)
    assert frame(city) == wanted
