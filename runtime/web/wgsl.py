# Write wgsl.mjs or wgsl_fog.mjs: of vxs_lookup.wgsl or vxs_fog.wgsl, which `make wgsl` translates, what some functions need, without
# indentation; see test_wgsl.py.
#
#     runtime/web/wgsl.py build/release/vxs_lookup.wgsl vxs_lit vxs_box vxs_smooth
#     runtime/web/wgsl.py build/release/vxs_fog.wgsl vxs_fog
# SPDX-License-Identifier: MIT
import pathlib
import re
import sys

text = pathlib.Path(sys.argv[1]).read_text()
items = {m[2]: m[0] for m in re.finditer(r"^(fn|struct|const)\s+(\w+).*?(?=^(?:fn|struct|const|@)|\Z)", text, re.M | re.S)}
needed, more = set(), ["vxs_light_of_texels", *sys.argv[2:]]
while more:
    name = more.pop()
    if name in items and name not in needed:
        needed.add(name)
        more += re.findall(r"\w+", items[name])
lines = (re.sub(r"\s+", " ", item).strip() for name, item in items.items() if name in needed)
print("// In WGSL, from formats/*.h and runtime/*.h by naga (make wgsl) and wgsl.py. SPDX-License-Identifier: MIT\nexport const wgsl = `\n" + "\n".join(lines) + "\n`;")
