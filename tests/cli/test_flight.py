# tests/bench/flight: what it prints is what it writes, and both are what the schema says.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import pathlib
import subprocess

import jsonschema
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def flight(vxs_path):
    path = vxs_path.parent / "tests" / "bench" / "flight"
    if not path.is_file():
        pytest.skip(f"no program at {path}: build it")
    return lambda *options: subprocess.run([path, *map(str, options)], capture_output=True, text=True, timeout=300)


@pytest.fixture(scope="module")
def city(vxs, tmp_path_factory):
    folder = tmp_path_factory.mktemp("flight")
    assert vxs("scene", "city", "-o", folder / "city.glb", "--triangles", 20000).returncode == 0
    assert vxs("bake", folder / "city.glb", "-o", folder / "city.vxs", "--resolution", 4096, "--pack", "fast").returncode == 0
    return folder / "city.vxs"


def test_a_flight_is_printed_and_written(flight, city, tmp_path):
    done = flight(city, "--budget", "3M", "--speed", 400, "--json", tmp_path / "flight.json")
    assert done.returncode == 0, done.stderr
    result = json.loads((tmp_path / "flight.json").read_text())
    jsonschema.validate(result, json.loads((ROOT / "docs" / "flight.schema.json").read_text()))
    assert result["room_bytes"] < result["held_bytes"] <= result["budget_bytes"] == 3 << 20
    assert result["open"]["bytes_read"] < city.stat().st_size / 2 < result["bytes_read"] <= 2 * city.stat().st_size
    answers = result["answers"]
    assert 0.9 * answers["asked"] < answers["full"] <= answers["asked"] > 1000
    assert f"{100 * answers['full'] / answers['asked']:.3f} % full of {answers['asked']}" in done.stdout
    assert f"{result['pages']['appeared']} came, {result['pages']['left']} left" in done.stdout


def test_what_is_wrong_is_said(flight, city, tmp_path):
    assert flight(city, "--speed", 0).returncode == 2
    assert flight().returncode == 2
    done = flight(city, "--budget", "100K")
    assert done.returncode != 0 and "memory" in done.stderr
    assert flight(tmp_path / "none.vxs").returncode != 0
