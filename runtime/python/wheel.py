#!/usr/bin/env python3
# Puts the module and the shared libraries into a wheel: wheel.py VERSION TO LIBRARY... `auditwheel repair` then adds what these link.
# SPDX-License-Identifier: MIT
import pathlib
import shutil
import subprocess
import sys
import sysconfig

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]


def main(version, to, *libraries):
    folder, about = pathlib.Path(to) / f"vxs-{version}", f"vxs-{version}.dist-info"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(HERE / "vxs", folder / "vxs", ignore=shutil.ignore_patterns("__pycache__"))
    for library in libraries:
        shutil.copy(library, folder / "vxs")
        subprocess.run(["strip", "--strip-unneeded", folder / "vxs" / pathlib.Path(library).name], check=True)
    (folder / about).mkdir()
    readme = (ROOT / "docs" / "python.md").read_text()
    (folder / about / "METADATA").write_text(
        f"Metadata-Version: 2.1\nName: vxs\nVersion: {version}\nSummary: Baked voxelized shadows: lookups and bakes with numpy\n"
        "License: MIT AND GPL-3.0-or-later\nRequires-Python: >=3.8\nRequires-Dist: numpy\nDescription-Content-Type: text/markdown\n\n" + readme)
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    (folder / about / "WHEEL").write_text(f"Wheel-Version: 1.0\nGenerator: vxs\nRoot-Is-Purelib: false\nTag: py3-none-{platform}\n")
    for name in ("LICENSE.MIT", "LICENSE.GPL-3.0"):
        shutil.copy(ROOT / name, folder / about)
    subprocess.run([sys.executable, "-m", "wheel", "pack", folder, "-d", to], check=True, stdout=subprocess.DEVNULL)


main(*sys.argv[1:])
