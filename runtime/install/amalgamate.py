#!/usr/bin/env python3
# Joins the runtime into two files, vxs.h and vxs.c: amalgamate.py FOLDER SOURCE.c...
# Sources of streams come last, and a program may leave them out.
# SPDX-License-Identifier: MIT
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
PUBLIC = ["vxs.h", "vxs_query.h", "vxs_stream.h"]
INCLUDE = re.compile(r'^\s*#\s*include\s+"(.+?)"')
LICENCE = (ROOT / "LICENSE.MIT").read_text().strip()

HEAD_OF_SOURCE = """
/* Macros, all optional:
 *   VXS_SYSTEM_ZSTD  zstd.h and xxhash.h of the system, and its libzstd, in place of zstddeclib.c beside this file
 *   VXS_NO_STREAM    without vxs_stream.h: needs no threads
 *   VXS_NO_FILES     without vxs_asset_open_file; with VXS_NO_STREAM */
#if !defined(_WIN32) && !defined(_POSIX_C_SOURCE)
#define _POSIX_C_SOURCE 200809L
#endif
#if defined(VXS_NO_STREAM) && !defined(VXS_ONE_THREAD)
#define VXS_ONE_THREAD
#endif
#ifdef __clang__ /* functions of headers */
#pragma clang diagnostic ignored "-Wunused-function"
#endif
#ifdef VXS_SYSTEM_ZSTD
#define XXH_INLINE_ALL
#include <xxhash.h>
#include <zstd.h>
#else
#include "zstddeclib.c"
#endif
#include "vxs.h"
"""


def path_of(name):
    found = [folder / name for folder in (ROOT, ROOT / "formats", ROOT / "runtime") if (folder / name).is_file()]
    return found[0] if found else None


def expanded(path, seen):
    """The lines of a file, with those of each header of the project in place of its first #include."""
    if path in seen:
        return
    seen.add(path)
    yield f"\n/* ---- {path.relative_to(ROOT)} ---- */\n\n"
    for line in path.read_text().splitlines(keepends=True):
        name = INCLUDE.match(line)
        other = name and path_of(name[1])
        if other:
            yield from expanded(other, seen)
        elif not re.match(r"\s*#\s*include\s+<(zstd|xxhash)\.h>", line):
            yield line


def main(folder, sources):
    folder, seen = pathlib.Path(folder), set()
    folder.mkdir(parents=True, exist_ok=True)
    notice = f"/* Made by `make amalgamation` of vxs, a library that looks up baked shadows.\n\n{LICENCE}\n*/\n"
    header = [line for name in PUBLIC for line in expanded(ROOT / "runtime" / name, seen)]
    (folder / "vxs.h").write_text(notice + "".join(header))
    is_stream = [pathlib.Path(source).name.startswith("stream") for source in sources]
    parts = [[line for source, last in zip(sources, is_stream) if last == wanted for line in expanded(ROOT / source, seen)] for wanted in (False, True)]
    (folder / "vxs.c").write_text(notice + HEAD_OF_SOURCE + "".join(parts[0]) + "\n#ifndef VXS_NO_STREAM\n" + "".join(parts[1]) + "\n#endif\n")


main(sys.argv[1], sys.argv[2:])
