# A browser without a window that shows pages: Chromium, controlled over a pipe (its DevTools protocol), so that one start serves
# all pages of a test run.
# SPDX-License-Identifier: GPL-3.0-or-later
import base64
import json
import os
import select
import shutil
import subprocess
import tempfile

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking",
         "--disable-component-update", "--disable-extensions", "--disable-sync", "--no-first-run", "--no-default-browser-check",
         "--no-proxy-server", "--host-resolver-rules=MAP * ~NOTFOUND", "--force-device-scale-factor=1", "--remote-debugging-pipe",
         "--enable-unsafe-webgpu"]


class Browser:
    """Shows one page at a time. requests: addresses that the page requested; complaints: errors, log lines and dialogs."""

    def __init__(self, flags=(), patience_s=60):
        self.patience_s = patience_s
        self.folder = tempfile.TemporaryDirectory(prefix="vxs-browser-")
        from_us, self.to = os.pipe()
        self.back, to_us = os.pipe()
        # the browser reads descriptor 3 and writes descriptor 4
        shell = f"exec 9<&{from_us} 8>&{to_us}; exec 3<&9 4>&8 9<&- 8>&-; exec \"$0\" \"$@\""
        self.process = subprocess.Popen(["bash", "-c", shell, shutil.which("chromium"), *FLAGS, *flags,
                                         f"--user-data-dir={self.folder.name}"], pass_fds=(from_us, to_us),
                                        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                        env=os.environ | {"HOME": self.folder.name})
        os.close(from_us)
        os.close(to_us)
        self.count, self.pending, self.events, self.session = 0, b"", [], None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self.call("Page.setLifecycleEventsEnabled", enabled=True)

    def send(self, method, parameters):
        self.count += 1
        message = {"id": self.count, "method": method, "params": parameters} | ({"sessionId": self.session} if self.session else {})
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.to, data):]

    def receive(self):
        while b"\0" not in self.pending:
            assert select.select([self.back], [], [], self.patience_s)[0], f"the browser says nothing for {self.patience_s} s"
            piece = os.read(self.back, 1 << 20)
            assert piece, "the browser is gone"
            self.pending += piece
        text, _, self.pending = self.pending.partition(b"\0")
        message = json.loads(text)
        if message.get("method") == "Page.javascriptDialogOpening":  # nothing goes on before it is answered
            self.send("Page.handleJavaScriptDialog", {"accept": False})
        return message

    def call(self, method, **parameters):
        self.send(method, parameters)
        number = self.count
        while (answer := self.receive()).get("id") != number:
            self.events.append(answer)
        assert "error" not in answer, answer
        return answer["result"]

    def show(self, path, width=1200, dark=False, media=""):
        """Load a file and run its scripts."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=900, deviceScaleFactor=1, mobile=False)
        self.call("Emulation.setEmulatedMedia", media=media,
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.events = []
        loader = self.call("Page.navigate", url=path.as_uri())["loaderId"]
        loaded = lambda e: e.get("method") == "Page.lifecycleEvent" and (e["params"]["loaderId"], e["params"]["name"]) == (loader, "load")
        while not any(map(loaded, self.events)):
            self.events.append(self.receive())

    @property
    def requests(self):
        return [e["params"]["request"]["url"] for e in self.events if e.get("method") == "Network.requestWillBeSent"]

    @property
    def complaints(self):
        return [e["params"] for e in self.events
                if e.get("method") in ("Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded",
                                        "Page.javascriptDialogOpening")]

    def ask(self, expression):
        """The value of an expression of JavaScript in the page, as JSON has it."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def photograph(self, path):
        """The whole page as PNG."""
        size = self.call("Page.getLayoutMetrics")["cssContentSize"]
        shot = self.call("Page.captureScreenshot", captureBeyondViewport=True,
                         clip={"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1})
        path.write_bytes(base64.b64decode(shot["data"]))

    def close(self):
        os.close(self.to)
        os.close(self.back)
        self.process.wait(timeout=30)
        self.folder.cleanup()
