# Requests to the add-on, inside Blender (inside.py).
# SPDX-License-Identifier: GPL-3.0-or-later
import functools
import importlib
import os
import resource
import subprocess
import tempfile
import time
import types

import addon_utils
import bpy

import scenes

NAME = "vxs_shadows"


class AddonRequests:
    module = None  # the add-on's package, once it is installed

    def install(self, path):
        """As a user installs a zip: as an extension where Blender has them. Returns the package."""
        if bpy.app.version >= (4, 2):
            bpy.ops.extensions.package_install_files(filepath=path, repo="user_default", enable_on_install=True)
            self.module = f"bl_ext.user_default.{NAME}"
        else:
            bpy.ops.preferences.addon_install(filepath=path)
            addon_utils.enable(NAME, default_set=True)
            self.module = NAME
        return [addon.module for addon in bpy.context.preferences.addons if NAME in addon.module]

    def part(self, name):
        return importlib.import_module(f"{self.module}.{name}")

    def switch(self, on):
        """Disable or enable the add-on."""
        if on:
            addon_utils.enable(self.module, default_set=True)
        else:
            addon_utils.disable(self.module, default_set=True)

    def traces(self):
        """What is there of the add-on: types, properties, operators, handlers."""
        holders = (bpy.types.Scene, bpy.types.Light, bpy.types.Object, bpy.types.WindowManager)
        handlers = [f"{name}: {f.__name__}" for name in dir(bpy.app.handlers) if isinstance(getattr(bpy.app.handlers, name), list)
                    for f in getattr(bpy.app.handlers, name) if NAME in f.__module__]
        return {"types": sorted(name for name in dir(bpy.types) if "vxs" in name.lower()),
                "classes": sorted(each.__name__ for kind in (bpy.types.PropertyGroup, bpy.types.Operator, bpy.types.Panel)
                                  for each in kind.__subclasses__() if NAME in each.__module__ and each.is_registered),
                "properties": sorted(holder.__name__ for holder in holders if hasattr(holder, "vxs")),
                "operators": sorted(name for name in dir(bpy.ops.vxs) if not name.startswith("_")), "handlers": handlers}

    def prefer(self, **values):
        preferences = bpy.context.preferences.addons[self.module].preferences
        for name, value in values.items():
            setattr(preferences, name, value)

    def set(self, path, name, value=None, collection=None):
        """Set a property of what an expression names: to a value, or to a collection by its name."""
        setattr(eval(path, {"bpy": bpy}), name, bpy.data.collections[collection] if collection else value)

    def get(self, expression):
        return eval(expression, {"bpy": bpy})

    def bake(self, **arguments):
        """What bpy.ops.vxs.bake() returns, or the error that it raises; and what the panel shows then."""
        try:
            outcome = list(bpy.ops.vxs.bake(**arguments))
        except RuntimeError as error:
            outcome = str(error).strip()
        return {"outcome": outcome, **self.state()}

    def state(self):
        state = bpy.context.window_manager.vxs
        return {"result": state.result, "filepath": state.filepath, "is_running": state.is_running,
                "messages": [{"level": message.level, "text": message.text, "named": [(thing.kind, thing.name) for thing in message.named]}
                             for message in state.messages]}

    def temporary_files(self):
        """But for those that Blender itself makes."""
        return sorted(name for name in os.listdir(tempfile.gettempdir()) if not name.startswith(("blender_", "pulse-")))

    def save_copy(self, path):
        bpy.ops.wm.save_as_mainfile(filepath=path, copy=True, compress=False)

    def save(self, path):
        bpy.ops.wm.save_as_mainfile(filepath=path, compress=False)

    def save_preferences(self):
        bpy.ops.wm.save_userpref()

    def bake_and_cancel(self, filepath, after=0.3, limit=60):
        """A bake as in a window, but that there is none here, cancelled after some seconds: what it says, and the seconds to the end."""
        operator = Operator(self.part("bake").VXS_OT_bake, filepath=filepath, resolution=16384, force=True)
        operator.work_left = operator.steps(bpy.context)
        operator.timer = bpy.context.window_manager.event_timer_add(0.1, window=bpy.context.window)
        start, cancelled, outcome = time.monotonic(), None, {"PASS_THROUGH"}
        while outcome == {"PASS_THROUGH"}:
            outcome = operator.modal(bpy.context, types.SimpleNamespace(type="TIMER"))
            if cancelled is None and time.monotonic() > start + after:
                assert not bpy.ops.vxs.bake.poll(), "two bakes at once"
                bpy.ops.vxs.cancel()
                cancelled = time.monotonic()
            assert time.monotonic() < start + after + limit, "it does not end"
            time.sleep(0.02)
        return {"outcome": list(outcome), "said": operator.said, "seconds": time.monotonic() - (cancelled or start), **self.state()}

    def time_bake(self, triangles, objects, resolution, runs, vxs, folder):
        """Seconds of bakes by the add-on, of what it writes for vxs alone, and of vxs with that file; in turn."""
        count = scenes.large(triangles, objects)
        level = os.path.join(folder, "level.glb")
        command = [vxs, "bake", level, "-o", os.path.join(folder, "vxs.vxs"), "--resolution", str(resolution), "--quiet", "--force"]
        actions = {"add-on": lambda: bpy.ops.vxs.bake(filepath=os.path.join(folder, "addon.vxs"), resolution=resolution, force=True),
                   "level": lambda: self.part("level").gather(bpy.context, self.part("level").Level(level))[1].write(bpy.context.scene),
                   "vxs": lambda: subprocess.run(command, check=True)}
        seconds = {name: [] for name in actions}
        for _ in range(runs):
            for name, act in actions.items():
                start = time.monotonic()
                act()
                seconds[name].append(time.monotonic() - start)
        same = [open(os.path.join(folder, f"{name}.vxs"), "rb").read() for name in ("addon", "vxs")]
        return {"triangles": count, "seconds": seconds, "is_same": same[0] == same[1]}

    def limit_files(self, size):
        """The largest file that this process and its children may write; None: any."""
        resource.setrlimit(resource.RLIMIT_FSIZE, (size or resource.RLIM_INFINITY, resource.RLIM_INFINITY))


class Operator:
    """Has the methods of an operator, which only Blender's windows can start, and the defaults of its properties."""

    def __init__(self, kind, **values):
        self.said, self.kind = [], kind
        for each in getattr(bpy.ops.vxs, kind.bl_idname.split(".")[1]).get_rna_type().properties:
            setattr(self, each.identifier, values.get(each.identifier, getattr(each, "default", None)))

    def __getattr__(self, name):
        value = next(vars(each)[name] for each in self.kind.__mro__ if name in vars(each))
        return functools.partial(value, self) if callable(value) else value

    def report(self, _level, text):
        self.said.append(text)
