# The lookup in WGSL, which `make wgsl` has naga translate: valid for naga and for Chromium, and run by Chromium (SwiftShader) and
# by wgpu (lavapipe), whose answers are held against C: from integer voxels bit for bit, from positions but for where float rounding
# decides between two voxels. None of naga, Chromium and wgpu is needed: tests that miss one are skipped. VXS_WGPU_PYTHON: a python
# that has wgpu of PyPI (default: the one that runs the tests).
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import functools
import json
import os
import shutil
import struct
import subprocess
import sys

import pytest

import voxels
from conftest import ROOT
from test_example import installed, pkg_config  # noqa: F401 (installed is a fixture)
from test_install import build, make  # noqa: F401 (build is a fixture)

LIT = (ROOT / "tests" / "shaders" / "lit.wgsl").read_text()
HEAD = """
struct lookup { light: u32, width_px: i32, is_smooth: i32, in_world: i32 }
struct row    { first: vec4f, second: vec4f }
@group(0) @binding(0) var<storage, read>       words: array<u32>;
@group(0) @binding(1) var<storage, read>       lights: array<vxs_light_constants>;
@group(0) @binding(2) var<storage, read>       rows: array<row>;
@group(0) @binding(3) var<storage, read_write> answers: array<f32>;
@group(0) @binding(4) var<uniform>             wanted: lookup;

fn vxs_word_at(at: u32) -> u32 { return words[at]; }

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u)
{
    if (id.x >= arrayLength(&rows)) { return; }
    let light = lights[wanted.light];
    let given = rows[id.x];
"""

# one lookup in the text, so that it is compiled once: at a place that is given, or at the place of a point (vxs_lit)
LOOK_UP = HEAD + """
    let pcf   = vxs_filter(wanted.width_px, wanted.is_smooth);
    var place = vxs_place(i32(given.second.x), vec3i(given.first.xyz), u32(given.second.y), u32(given.second.z));
    if (wanted.in_world != 0) { place = vxs_place_from_ws(light, given.first.xyz, given.second.xyz, pcf); }
    var lit = VXS_OUTSIDE;
    if (place.map >= 0) { lit = vxs_lit_at_place(light.first_word, light, place, pcf); }
    answers[id.x] = lit;
}
"""

WALK = HEAD + """
    var walk = vxs_walk_of(light, given.first.xyz, given.second.xyz, 0.0, 1.0);
    var span: vxs_span;
    var lit = 0.0;
    while (vxs_walk_next(light.first_word, light, &walk, &span) != 0) {
        if (span.state == VXS_SPAN_LIT) { lit += span.end - span.begin; }
    }
    answers[id.x] = lit;
}
"""

# run(text, cases): each case is {in_world, light, width, words, lights, rows}, the last three in base64. Returns the bits of answers
PAGE = """<script>
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0));
async function device() {
    const adapter = navigator.gpu && await navigator.gpu.requestAdapter();
    return adapter && await adapter.requestDevice();
}
async function complaints(text) {
    const info = await (await device()).createShaderModule({code: text}).getCompilationInfo();
    return info.messages.map(m => `${m.type}, line ${m.lineNum}: ${m.message}`);
}
async function run(text, cases) {
    const gpu = await device(), module = gpu.createShaderModule({code: text}), found = [];
    const layout = gpu.createBindGroupLayout({entries: [0, 1, 2, 3, 4].map(binding => ({binding, visibility: GPUShaderStage.COMPUTE,
        buffer: {type: binding < 3 ? "read-only-storage" : binding == 3 ? "storage" : "uniform"}}))});
    const buffer = (data, usage) => {
        const made = gpu.createBuffer({size: data.byteLength, usage: usage | GPUBufferUsage.COPY_DST});
        gpu.queue.writeBuffer(made, 0, data);
        return made;
    };
    const pipeline = await gpu.createComputePipelineAsync({layout: gpu.createPipelineLayout({bindGroupLayouts: [layout]}),
                                                           compute: {module}});
    for (const c of cases) {
        const rows = bytes(c.rows), size = rows.length / 8;
        const answers = gpu.createBuffer({size, usage: GPUBufferUsage.STORAGE | GPUBufferUsage.COPY_SRC});
        const back = gpu.createBuffer({size, usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ});
        const wanted = new Int32Array([c.light, Math.abs(c.width), c.width < 0, c.in_world]);
        const buffers = [...[bytes(c.words), bytes(c.lights), rows].map(data => buffer(data, GPUBufferUsage.STORAGE)), answers,
                         buffer(wanted, GPUBufferUsage.UNIFORM)];
        const commands = gpu.createCommandEncoder(), pass = commands.beginComputePass();
        pass.setPipeline(pipeline);
        pass.setBindGroup(0, gpu.createBindGroup({layout, entries: buffers.map((buffer, binding) => ({binding, resource: {buffer}}))}));
        pass.dispatchWorkgroups(Math.ceil(size / 256));
        pass.end();
        commands.copyBufferToBuffer(answers, 0, back, 0, size);
        gpu.queue.submit([commands.finish()]);
        await back.mapAsync(GPUMapMode.READ);
        found.push([...new Uint32Array(back.getMappedRange())]);
    }
    return found;
}
</script>"""

WGPU = """
import base64, json, sys
import wgpu

text, cases = json.load(sys.stdin)
gpu = wgpu.gpu.request_adapter_sync().request_device_sync()
module, found = gpu.create_shader_module(code=text), []
kinds = ["read-only-storage"] * 3 + ["storage", "uniform"]
layout = gpu.create_bind_group_layout(entries=[{"binding": n, "visibility": wgpu.ShaderStage.COMPUTE, "buffer": {"type": kind}}
                                               for n, kind in enumerate(kinds)])
pipeline = gpu.create_compute_pipeline(layout=gpu.create_pipeline_layout(bind_group_layouts=[layout]), compute={"module": module})
for c in cases:
    data = [base64.b64decode(c[name]) for name in ("words", "lights", "rows")]
    wanted = b"".join(int(x).to_bytes(4, "little") for x in (c["light"], abs(c["width"]), c["width"] < 0, c["in_world"]))
    buffers = [gpu.create_buffer_with_data(data=d, usage=wgpu.BufferUsage.STORAGE) for d in data]
    answers = gpu.create_buffer(size=len(data[2]) // 8, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
    buffers += [answers, gpu.create_buffer_with_data(data=wanted, usage=wgpu.BufferUsage.UNIFORM)]
    commands = gpu.create_command_encoder()
    work = commands.begin_compute_pass()
    work.set_pipeline(pipeline)
    work.set_bind_group(0, gpu.create_bind_group(layout=layout, entries=[{"binding": n, "resource": {"buffer": b}} for n, b in enumerate(buffers)]))
    work.dispatch_workgroups(-(-len(data[2]) // 2048))
    work.end()
    gpu.queue.submit([commands.finish()])
    found.append(list(gpu.queue.read_buffer(answers).cast("I")))
json.dump(found, sys.stdout)
"""


@pytest.fixture(scope="module")
def texts(build, tmp_path_factory):  # noqa: F811
    """What `make wgsl` writes: {"lookup": text, "intervals": text, "fog": text}."""
    for tool in ("glslangValidator", "naga"):
        if not shutil.which(tool):
            pytest.skip(f"no {tool}: glslang-tools of Debian, naga-cli of crates.io")
    folder = tmp_path_factory.mktemp("wgsl")
    make(folder, "wgsl")
    return {name: (folder / f"vxs_{name}.wgsl").read_text() for name in ("lookup", "intervals", "fog")}


@pytest.fixture(scope="module")
def cases(installed, tmp_path_factory):  # noqa: F811
    """What shaders are given, and a function that checks each answer: {"lookup": [(case, check)], "intervals": [(case, check)]}."""
    folder = tmp_path_factory.mktemp("places")
    program = voxels.compile_places(folder, pkg_config(installed / "lib" / "pkgconfig", {}, "--cflags", "--libs"))
    found = {"lookup": [], "intervals": []}
    for name, light, width in voxels.CASES:
        here = folder / f"{name}-{light}-{width}"
        _, of_voxels, _, of_points, _, of_rays = voxels.write_places(program, here, name, light, width, installed / "lib")
        for rows, text, check, answers in (("voxels", "lookup", check_voxels, [lit for _, lit in of_voxels]),
                                           ("points", "lookup", voxels.check_points, of_points), ("rays", "intervals", voxels.check_rays, of_rays)):
            read = {file: base64.b64encode((here / path).read_bytes()).decode() for file, path in (("words", "words"), ("lights", "lights"), ("rows", rows))}
            case = {"in_world": int(rows == "points"), "light": light, "width": width, **read}
            found[text].append((case, functools.partial(check, answers=answers)))
    return found


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "gpu.html"
    path.write_text(PAGE)
    browser.show(path)
    if not browser.ask("device().then(Boolean)"):
        pytest.skip("this Chromium has no WebGPU")
    return browser


def check_voxels(found, answers):
    assert found == answers


def check(found, cases):
    assert len(found) == len(cases) > 0
    for bits, (_, check_answers) in zip(found, cases):
        check_answers(list(struct.unpack(f"{len(bits)}f", struct.pack(f"{len(bits)}I", *bits))))


BODIES = {"lookup": LOOK_UP, "intervals": WALK}


def test_naga_compiles(texts, tmp_path):
    """To SPIR-V, for which more has to be right than for naga to accept a text; also where code for other lights and filters is left out."""
    make(tmp_path, "wgsl", "only=KIND=1 CUBE=0 CODING=2 WIDTH=9 SMOOTH=0")
    small = (tmp_path / "vxs_lookup.wgsl").read_text()
    assert small != texts["lookup"]
    for text in (small + LIT, texts["lookup"] + LIT, texts["intervals"] + LIT, texts["lookup"] + LOOK_UP, texts["intervals"] + WALK):
        (tmp_path / "whole.wgsl").write_text(text)
        done = subprocess.run(["naga", tmp_path / "whole.wgsl", tmp_path / "whole.spv"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name, module, roots", [("lookup", "wgsl", ["vxs_lit", "vxs_box", "vxs_smooth"]), ("fog", "wgsl_fog", ["vxs_fog"])])
def test_web_modules_are_up_to_date(texts, tmp_path, name, module, roots):
    """vxs/three/webgpu has the functions of these texts: after a change of headers, run runtime/web/wgsl.py."""
    text = tmp_path / f"vxs_{name}.wgsl"
    text.write_text(texts[name])
    made = subprocess.run([sys.executable, ROOT / "runtime" / "web" / "wgsl.py", text, *roots], stdout=subprocess.PIPE, text=True, check=True).stdout
    assert made == (ROOT / "runtime" / "web" / "three" / f"{module}.mjs").read_text()


def test_chromium_accepts(texts, page):
    for text in (texts["lookup"] + LIT, texts["lookup"] + LOOK_UP, texts["intervals"] + WALK):
        assert page.ask(f"complaints({json.dumps(text)})") == []
    assert "unresolved" in page.ask(f"complaints({json.dumps(LIT)})")[0]


@pytest.mark.parametrize("name", BODIES)
def test_chromium_answers(texts, cases, page, name):
    check(page.ask(f"run({json.dumps(texts[name] + BODIES[name])}, {json.dumps([case for case, _ in cases[name]])})"), cases[name])


@pytest.mark.parametrize("name", BODIES)
def test_wgpu_answers(texts, cases, name):
    python = os.environ.get("VXS_WGPU_PYTHON", sys.executable)
    if subprocess.run([python, "-c", "import wgpu"], capture_output=True).returncode:
        pytest.skip("no wgpu: of PyPI")
    if not voxels.LAVAPIPE:
        pytest.skip("no lavapipe: package mesa-vulkan-drivers")
    done = subprocess.run([python, "-c", WGPU], input=json.dumps([texts[name] + BODIES[name], [case for case, _ in cases[name]]]),
                          capture_output=True, text=True,
                          env=os.environ | {"WGPU_BACKEND_TYPE": "Vulkan", "VK_ICD_FILENAMES": str(voxels.LAVAPIPE)})
    assert done.returncode == 0, done.stderr
    check(json.loads(done.stdout), cases[name])
