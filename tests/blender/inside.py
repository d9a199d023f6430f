# Runs inside Blender, and does what tests ask for: a line of JSON for each request and each answer, on two pipes.
#
#   blender -b --factory-startup --python inside.py -- READ_FD WRITE_FD       or, with the module bpy,  python inside.py -- READ_FD WRITE_FD
# SPDX-License-Identifier: GPL-3.0-or-later
import json
import os
import pathlib
import sys
import traceback

import bpy
import numpy as np
from mathutils import Vector

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import scenes  # noqa: E402  bpy comes first: it makes bmesh known
import truth  # noqa: E402
import with_addon  # noqa: E402
import with_preview  # noqa: E402

LIFT = 2e-5  # of the scene's size: how far a ray starts above its surface
TURN = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], float)  # Blender's axes to those of glTF


class Session(with_addon.AddonRequests, with_preview.PreviewRequests):
    """Requests are methods; what they keep for one another are members."""

    def version(self):
        return list(bpy.app.version)

    def make(self, scene):
        scenes.make(scene)

    def names(self):
        return list(scenes.SCENES)

    def export(self, path, **more):
        """The file that a user exports by hand, for shadows: what is visible and is rendered, with lights."""
        # the exporter writes particles twice where it is asked for instances of geometry nodes, and metaballs only where it is
        has_particles = any(thing.particle_systems for thing in bpy.data.objects)
        known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
        wanted = dict(export_lights=True, use_visible=True, use_renderable=True, export_apply=True, export_gpu_instances=True,
                      export_gn_mesh=not has_particles, export_animations=False, **more)
        bpy.ops.export_scene.gltf(filepath=path, export_format="GLB", **{key: value for key, value in wanted.items() if key in known})

    def receivers(self, count, seed, left_out=()):
        """Points on surfaces, as lines for `vxs query`, and the true answers of each light by its name."""
        truth.show_only_what_casts(set(left_out))
        self.rays = truth.Rays()
        self.points = truth.receivers(self.rays, count, seed)
        self.lamps = {lamp.name: lamp for lamp in truth.lamps()}
        triangles = truth.world_triangles(self.rays)
        self.lift = LIFT * float((triangles.max(axis=(0, 1)) - triangles.min(axis=(0, 1))).max())
        self.answers = {name: [truth.answer(self.rays, lamp, self.lifted(n)) for n in range(count)] for name, lamp in self.lamps.items()}
        turned = np.concatenate([self.points[:, :3] @ TURN.T, self.points[:, 3:] @ TURN.T], axis=1)
        return {"points": [" ".join(map(repr, row)) for row in turned.tolist()], "answers": self.answers}

    def lifted(self, n):
        return Vector(self.points[n, :3]) + self.lift * Vector(self.points[n, 3:])

    def explain(self, light, texel, voxel, differ):
        """Of points that differ, pairs of a number and the file's answer: why, as truth.Explainer says."""
        explainer = truth.Explainer(self.rays, self.lamps[light], texel, voxel)
        return [explainer.explain(self.lifted(n), Vector(self.points[n, 3:]), given) for n, given in differ]


def main():
    read, write = map(int, sys.argv[sys.argv.index("--") + 1:])
    session = Session()
    with os.fdopen(read) as requests, os.fdopen(write, "w") as replies:
        for line in requests:
            request = json.loads(line)
            try:
                reply = {"result": getattr(session, request.pop("do"))(**request)}
            except Exception:
                reply = {"error": traceback.format_exc()}
            print(json.dumps(reply), file=replies, flush=True)


main()
