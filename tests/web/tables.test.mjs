// Tables of vxs/three, read as runtime/gl/gl_tables.h describes them: the depth of each texel is that of the runtime.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';

const VXS = process.env.VXS ?? new URL('../../build/release/vxs', import.meta.url).pathname;
const PACKAGE = process.env.VXS_PACKAGE ?? new URL('../../build/web/vxs', import.meta.url).pathname;
const load = (file) => import(pathToFileURL(path.join(PACKAGE, file)));

/** Depths of a search tree in order: the children of delta m, counted from 1, are 2m and 2m + 1. */
const inOrder = (tree, m = 1) => (m > tree.length ? [] : [...inOrder(tree, 2 * m), tree[m - 1], ...inOrder(tree, 2 * m + 1)]);

/** Where shadow begins; bounds of the square and of the block must hold it. */
function depthOf(words, { levels }, map, i, j) {
  const up = Math.max(levels, 8) - 8, square = words[(map << (2 * up)) + ((j >> 8) << up) + (i >> 8)];
  if (square >= 2 ** 31) return square - 2 ** 31;
  const block = words[square + 4 + ((i >> 5) & 7) + 8 * ((j >> 5) & 7)], bounds = [[words[square + 1], words[square + 2]]];
  let depth = block - 2 ** 31;
  if (block < 2 ** 31) {
    const tile = block + 2 + 2 * ((i >> 3) & 3) + 8 * ((j >> 3) & 3), bits = words[tile + 1] >>> 28, record = words[tile + 1] % 2 ** 28;
    const planes = record + 2 ** bits - 1, texel = (i & 7) + 8 * (j & 3);
    let rank = 0;
    for (let n = 0; n < bits; n++) rank = 2 * rank + ((words[planes + 2 * n + ((j >> 2) & 1)] >>> texel) & 1);
    depth = words[tile] + [0, ...inOrder(words.subarray(record, planes))][rank];
    bounds.push([words[block], words[block + 1]]);
  }
  const shown = Math.min(depth, 2 ** levels);
  for (const [least, greatest] of bounds) assert.ok(least <= shown && shown <= greatest, `${i} ${j}: ${shown} of ${least} to ${greatest}`);
  return shown;
}

test('tables have the depth of every texel', async () => {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-tables-')), vxs = (...args) => execFileSync(VXS, args, { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  try {
    const { tablesOf } = await load('three/tables.mjs'), runtime = await (await load('runtime/vxs.mjs')).load();
    vxs('scene', 'room', '-o', 'room.glb', '--triangles', '20000');
    vxs('scene', 'city', '-o', 'city.glb', '--triangles', '20000');
    for (const [scene, resolution] of [['room', 8], ['room', 64], ['room', 512], ['city', 256], ['city', 2048]]) {
      vxs('bake', `${scene}.glb`, '-o', 'level.vxs', '--resolution', `${resolution}`, '--force', '--quiet');
      const asset = runtime.open(fs.readFileSync(path.join(folder, 'level.vxs')));
      for (const light of asset.lights) {
        const words = tablesOf(light), step = Math.max(1, resolution >> 8) * 2 - 1, depths = new Set();
        for (let map = 0; map < light.maps; map++)
          for (let j = 0; j < resolution; j += step)
            for (let i = 0; i < resolution; i += step) {
              const wanted = light.firstShadow(map, i, j);
              depths.add(wanted);
              if (depthOf(words, light, map, i, j) !== wanted) assert.fail(`${scene} ${resolution} ${light.name}: texel ${i} ${j} of map ${map}`);
            }
        assert.ok(resolution < 64 || depths.size > 20);
      }
      asset.dispose();
    }
  } finally {
    fs.rmSync(folder, { recursive: true });
  }
});
