#!/usr/bin/env python3
# Writes the lookup in Godot's shading language: shader_text.py CC >vxs.gdshaderinc. The C preprocessor expands the texts of formats/, as
# HLSL whose types are named as GLSL names them; of these, the functions that lookups need, between shader_head and shader_tail.
# Godot's language differs from GLSL ES 3.00: both sides of a shift have one type, and a field of a struct has a type of its own.
# SPDX-License-Identifier: MIT
import pathlib
import re
import subprocess
import sys

HEADERS = ("vxs_lookup.h", "vxs_lookup_blocks.h", "vxs_space.h")
MACROS = ("VXS_HLSL", "VXS_ONLY_CODING=2", "vxs_word(dag,i)=vxs_fetch((dag)+(i))", "countbits=vxs_count_bits", "asfloat=uintBitsToFloat",
          "float3=vec3", "float4=vec4", "int3=ivec3", "uint4=uvec4")
ROOTS = ("vxs_light_of_texels", "vxs_lit", "vxs_box", "vxs_smooth")
TOKEN = re.compile(r"\d[\w.]*(?:(?<=e)-\d+)?|[\w.]+|<<|>>|[^\w\s]|\s+")


def expanded(compiler):
    text = "".join(f'#include "formats/{header}"\n' for header in HEADERS)
    command = [*compiler.split(), "-E", "-P", "-undef", "-nostdinc", "-x", "c", "-I.", *(f"-D{macro}" for macro in MACROS), "-"]
    text = subprocess.run(command, input=text, stdout=subprocess.PIPE, text=True, check=True).stdout
    return re.sub(r"\((\w+)\)(?=\.|\+)", r"\1", text)


def parts(text):
    """{name: text} of structs and functions, in their order."""
    found = re.finditer(r"^ *(?:struct (\w+) \{.*?^\};|[\w ]+? (\w+)\([^;{]*\)\s*\{.*?^\})", text, re.M | re.S)
    return {match[1] or match[2]: match[0].strip() for match in found}


def needed(items):
    names, more = set(), list(ROOTS)
    while more:
        name = more.pop()
        if name in items and name not in names:
            names.add(name)
            more += re.findall(r"\w+", items[name])
    return [text for name, text in items.items() if name in names]


def begin_of(tokens, end):
    """Where the operand starts whose last token is `end`."""
    at, depth = end, 0
    while True:
        depth += (tokens[at] in ")]") - (tokens[at] in "([")
        if depth == 0 and not (tokens[at] in "([" and at > 0 and re.match(r"\w", tokens[at - 1])):
            return at
        at -= 1


def end_of(tokens, begin):
    """The last token of the operand that starts at `begin`."""
    at, depth = begin, 0
    while True:
        depth += (tokens[at] in "([") - (tokens[at] in ")]")
        if depth == 0 and not (at + 1 < len(tokens) and tokens[at + 1] in ("(", "[") and re.match(r"\w", tokens[at])):
            return at
        at += 1


def type_of(tokens, types):
    """uint or int: that of the first operand, as all operands of an expression have one type; of a condition that behind the ?."""
    for token in tokens[tokens.index("?") if tokens[0] == "(" and "?" in tokens else 0:]:
        if re.match(r"\d", token):
            return "uint" if token.endswith("u") else "int"
        if re.match(r"\w", token):
            return types[token.split(".")[-1]]
    raise ValueError("".join(tokens))


def with_equal_shifts(text, types):
    """The right side of each shift in the type of its left side."""
    tokens = TOKEN.findall(text)
    for at in [n for n, token in enumerate(tokens) if token in ("<<", ">>")]:
        words = [n for n, token in enumerate(tokens) if token.strip()]
        left, right = words[words.index(at) - 1], words[words.index(at) + 1]
        begin, end = begin_of(tokens, left), end_of(tokens, right)
        wanted, got = type_of(tokens[begin:left + 1], types), type_of(tokens[right:end + 1], types)
        if wanted != got:
            whole = "".join(tokens[right:end + 1])
            plain = whole.rstrip("u") + ("u" if wanted == "uint" else "")
            tokens[right:end + 1] = [plain if whole[0].isdigit() else f"{wanted}({whole})", *[""] * (end - right)]
    return "".join(tokens)


def with_single_fields(text):
    def split(match):
        return "".join(f"    {match[1]} {name};\n" for name in re.split(r",\s*", match[2]))

    return re.sub(r"^ +(\w+) (\w+(?:,\s*\w+)+);\n", split, text, flags=re.M) if text.startswith("struct") else text


def types_in(text):
    """uint or int of the names that a text declares: `uint a, b = f(c, d), e;`, and parameters."""
    tokens, types = [token for token in TOKEN.findall(text) if token.strip()], {}
    for n, kind in enumerate(tokens[:-1]):
        if kind not in ("uint", "int") or not re.match(r"\w", tokens[n + 1]):
            continue
        types[tokens[n + 1]], depth = kind, 0
        for before, token in zip(tokens[n + 1:], tokens[n + 2:]):
            depth += (before in "([") - (before in ")]")
            if depth < 0 or token in ";{":
                break
            if depth == 0 and before == "," and token not in ("uint", "int"):
                types.setdefault(token, kind)
    return types


def main(compiler):
    items = needed(parts(expanded(compiler)))
    shared = {"uint": "uint", "int": "int", "vxs_fetch": "uint", "vxs_count_bits": "uint"}
    for text in items:
        shared |= types_in(text if text.startswith("struct") else text.partition("(")[0])
    items = [with_single_fields(with_equal_shifts(text, shared | types_in(text))) for text in items]
    folder = pathlib.Path(__file__).parent
    head, tail = ((folder / f"shader_{part}.gdshaderinc").read_text() for part in ("head", "tail"))
    print("\n".join([head, *items, "", tail]), end="")


main(*sys.argv[1:])
