# One surface in many encodings is one asset: all sections but the metadata have the same bytes.
# SPDX-License-Identifier: GPL-3.0-or-later
import struct
import subprocess

import pytest

# Every file of encodings/, and the file whose bytes it has. Three hold other positions than the rest, and cannot be equal:
# spot_quantized is rounded to 14 bits, spot_meshopt is the same with its buffers compressed, spot_draco is rounded by Draco.
ENCODINGS = {
    "spot.glb": "spot.glb",
    "spot_datauri.gltf": "spot.glb",
    "spot_deep_nodes.glb": "spot.glb",
    "spot_draco.glb": "spot_draco.glb",
    "spot_fans.glb": "spot.glb",
    "spot_meshopt.glb": "spot_quantized.glb",
    "spot_negative_scale.glb": "spot.glb",
    "spot_noindex.glb": "spot.glb",
    "spot_quantized.glb": "spot_quantized.glb",
    "spot_separate/spot.gltf": "spot.glb",
    "spot_sparse.glb": "spot.glb",
    "spot_sparse_no_view.glb": "spot.glb",
    "spot_strided.glb": "spot.glb",
    "spot_strip.glb": "spot.glb",  # 29,275 of its triangles collapse and are left out
    "spot_u32.glb": "spot.glb",
    "spot_u8_chunks.glb": "spot.glb",
}


def sections(path):
    """(kind, light, level) and bytes of every section but the metadata (formats/vxs.md)."""
    data = path.read_bytes()
    found = []
    for i in range(struct.unpack_from("<I", data, 12)[0]):
        kind, _, light, level, offset, size = struct.unpack_from("<4sIIIQQ", data, 64 + 48 * i)
        if kind != b"META":
            found.append((kind, light, level, data[offset:offset + size]))
    return found


@pytest.fixture(scope="module")
def baked(vxs, scenes, tmp_path_factory):
    """sections(name, resolution) of a real scene, each baked once."""
    folder, known = tmp_path_factory.mktemp("encodings"), {}

    def bake(name, resolution=512):
        if (name, resolution) not in known:
            asset = folder / f"{len(known)}.vxs"
            vxs("bake", scenes / "real" / name, "-o", asset, "--sun", "-0.3,-1,-0.2", "--resolution", resolution)
            known[name, resolution] = sections(asset)
        return known[name, resolution]

    return bake


def test_every_encoding_is_listed(scenes):
    folder = scenes / "real" / "encodings"
    assert {str(p.relative_to(folder)) for p in folder.rglob("*.gl*") if p.suffix in (".glb", ".gltf")} == set(ENCODINGS)


@pytest.mark.parametrize("name", ENCODINGS)
def test_encodings_of_one_mesh_are_one_asset(baked, name):
    assert baked(f"encodings/{name}") == baked(f"encodings/{ENCODINGS[name]}")


def test_rounded_copies_are_others(baked):
    """The sections differ where the surface does: otherwise the test above compares nothing."""
    assert len({str(baked(f"encodings/{name}")) for name in ENCODINGS.values()}) == 3


@pytest.mark.parametrize("name", [n for n in ENCODINGS if ENCODINGS[n] == "spot.glb"])
def test_encodings_at_full_resolution(baked, name):
    assert baked(f"encodings/{name}", 4096) == baked("encodings/spot.glb", 4096)


def test_instances_are_the_nodes_they_stand_for(baked):
    assert baked("kaykit_city_gpu_instancing.glb") == baked("kaykit_city.glb")


@pytest.mark.parametrize("name", ["encodings/spot_draco.glb", "encodings/spot_meshopt.glb", "encodings/spot_quantized.glb",
                                  "features/heart_draco.glb", "features/pirate_meshopt_quantized.glb"])
def test_hostile_compressed_files(vxs_path, scenes, tmp_path, name):
    """Every 97th byte changed: a line that gives the reason, or another mesh; never a crash."""
    good, bad, out = (scenes / "real" / name).read_bytes(), tmp_path / "bad.glb", tmp_path / "out.vxs"
    start = 20 + struct.unpack_from("<I", good, 12)[0] + 8
    step = max(97, (len(good) - start) // 60)
    for at in range(start, len(good), step):
        bad.write_bytes(good[:at] + bytes([good[at] ^ 0x55]) + good[at + 1:])
        done = subprocess.run([vxs_path, "bake", bad, "-o", out, "--sun", "0,-1,0", "--resolution", "8"],
                              capture_output=True, text=True, timeout=60)
        assert done.returncode in (0, 3, 5), f"byte {at}: {done.returncode} {done.stderr}"
        assert done.returncode == 0 or done.stderr.count("vxs: error:") == 1


def test_draco_data_of_another_size_than_its_accessor(vxs, scenes, tmp_path):
    good, bad = (scenes / "real" / "encodings" / "spot_draco.glb").read_bytes(), tmp_path / "bad.glb"
    assert good.count(b'"count":17568') == 1
    for count in (17565, 17571, 99999):
        bad.write_bytes(good.replace(b'"count":17568', b'"count":%d' % count))
        says = vxs("bake", bad, "-o", tmp_path / "out.vxs", "--sun", "0,-1,0", status=3).stderr
        assert f"holds 5856 triangles, accessor 0 says {count} indices" in says
