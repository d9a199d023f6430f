# Pages of measurements: what makes them, refuses to, and what is reported on them.
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import re
import subprocess

import jsonschema

from page import Page

NASTY = ["<script>alert(1)</script>", "\"><img src=x onerror=alert(1)>", "it's `touch pwned` \\", "'; system('touch pwned') #",
         "two\nlines\tand \u0001", "%s%n %d $HOME ${HOME} @a _b ^c {d", "&#x0; &#60;b&#62; &lt;", "\ufffe\uffff \u202eback", "x" * 300,
         "]]> --> </svg></title></style>", "</script><script>alert(1)</script>", "<!--<script>", ""]


def nine_digits(value):
    """Numbers as vxs writes them."""
    return json.loads(json.dumps(value), parse_float=lambda text: float(f"{float(text):.9g}"))


def pages_of(vxs, browser, folder, schema):
    """report(*measurements): the page of JSONs that are first checked against the schema."""

    def report(*measurements, check=True):
        for n, content in enumerate(measurements):
            if check:
                jsonschema.Draft202012Validator(schema).validate(content)
            (folder / f"b{n}.json").write_text(json.dumps(content))
        vxs("report", *(folder / f"b{n}.json" for n in range(len(measurements))), "-o", folder / "out.html")
        page = Page(browser, folder / "out.html")
        assert [f["bench"] for f in page.data["files"]] == nine_digits(measurements), "the figures are those of the files"
        return page

    return report


def rejections_of(vxs_path, folder):
    """rejected(status, content or text, *arguments): the one line of an error; no page."""

    def rejected(status, content, *arguments):
        text = content if isinstance(content, str) else json.dumps(content)
        (folder / "b.json").write_text(text)
        before = sorted(folder.iterdir())
        done = subprocess.run([vxs_path, "report", folder / "b.json", *(arguments or ("-o", folder / "out.html"))],
                              capture_output=True, text=True)
        assert (done.returncode, done.stdout) == (status, ""), done.stderr
        assert done.stderr.startswith("vxs: error: ") and done.stderr.count("\n") == 1
        assert sorted(folder.iterdir()) == before and (folder / "b.json").read_text() == text
        return done.stderr

    return rejected


def told_at(browser, chart, line, point):
    """What a chart of the page says where the mouse is on a point; None where it says nothing."""
    at = browser.ask(f"""(() => {{
        const canvas = document.querySelector("#{chart} canvas");
        canvas.scrollIntoView();
        const {{x, y}} = Chart.getChart(canvas).getDatasetMeta({line}).data[{point}], box = canvas.getBoundingClientRect();
        return {{x: box.x + x, y: box.y + y}};
    }})()""")
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", **at)
    opacity, lines = browser.ask(f"""new Promise((told) => setTimeout(() => {{
        const {{opacity, body}} = Chart.getChart(document.querySelector("#{chart} canvas")).tooltip;
        told([opacity, body[0].lines]);
    }}, 100))""")
    return re.sub(r"\s", " ", lines[0]) if opacity == 1 else None
