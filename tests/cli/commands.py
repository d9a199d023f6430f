# What the help of the command says, as tables.
# SPDX-License-Identifier: GPL-3.0-or-later
import re

COMMANDS = ["bake", "plan", "merge", "info", "validate", "query", "view", "export", "truth", "compare", "bench", "report", "render", "health", "mend", "scene"]


def rows(vxs, command):
    """[(group, "--name" or "OPERAND", its value or "", the text)] of --help, lines that are wrapped put together."""
    found, group = [], None
    for line in vxs(command, "--help").stdout.splitlines():
        if re.fullmatch(r"\S.*:", line):
            group = line[:-1]
        elif row := re.fullmatch(r"  (\S+)(?: (\S+))?(?:  +(\S.*))?", line):
            found.append([group, row[1], row[2] or "", row[3] or ""])
        elif line.startswith("    "):
            found[-1][3] = f"{found[-1][3]} {line.strip()}".strip()
    return [tuple(row) for row in found]


def options(vxs, command):
    return [row for row in rows(vxs, command) if row[1].startswith("-")]
