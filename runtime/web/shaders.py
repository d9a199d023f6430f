# Write the module `vxs/shaders`: the texts of headers as JavaScript strings, without comments and includes (a shader is made of several
# texts, and three.js has includes of its own), and without what only C compiles.
# SPDX-License-Identifier: MIT
import json
import pathlib
import re
import sys


def shader_lines(lines):
    """The lines without branches of VXS_C; conditions of other macros stay."""
    branches = []  # of each open condition: whether its branch is for shaders; None if it does not ask for VXS_C
    for line in lines:
        directive = re.match(r"\s*#\s*(ifdef|ifndef|if|elif|else|endif)\b\s*(.*)", line)
        word, condition = directive.groups() if directive else ("", "")
        opens = word in ("ifdef", "ifndef", "if")
        if opens and (condition == "VXS_C" or condition.startswith("defined(VXS_C) &&")):
            branches.append(word == "ifndef")
        elif word == "elif" and branches[-1] is False:
            branches[-1] = None
            if False not in branches:
                yield f"#if {condition}"
        elif word in ("else", "endif") and branches[-1] is not None:
            branches.append(not branches.pop())
            if word == "endif":
                branches.pop()
        else:
            if False not in branches:
                yield line
            if opens:
                branches.append(None)
            elif word == "endif":
                branches.pop()


print("// Texts of formats/*.h for GLSL ES 3.00, GLSL 3.30 and later, HLSL. SPDX-License-Identifier: MIT")
for header in map(pathlib.Path, sys.argv[1:]):
    lines = re.sub(r"/\*.*?\*/", " ", header.read_text(), flags=re.S).splitlines()
    kept = shader_lines(line.rstrip() for line in lines if line.strip() and not line.startswith("#include"))
    name = header.stem if header.stem.startswith("vxs_") else f"vxs_{header.stem}"
    print(f"export const {name} = {json.dumps(''.join(f'{line}{chr(10)}' for line in kept))};")
