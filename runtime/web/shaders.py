# Write the module `vxs/shaders`: the texts of headers as JavaScript strings, without comments and includes: a shader
# is made of several texts, and three.js has includes of its own.
# SPDX-License-Identifier: MIT
import json
import pathlib
import re
import sys

print("// Texts of formats/*.h for GLSL ES 3.00, GLSL 3.30 and later, HLSL. SPDX-License-Identifier: MIT")
for header in map(pathlib.Path, sys.argv[1:]):
    text = re.sub(r"/\*.*?\*/", " ", header.read_text(), flags=re.S)
    text = "\n".join(line.rstrip() for line in text.splitlines() if line.strip() and not line.startswith("#include"))
    print(f"export const {header.stem} = {json.dumps(text + chr(10))};")
