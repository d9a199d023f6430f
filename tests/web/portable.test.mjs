// WebAssembly has another C library and another compiler than the native command: files have the same bytes all the same
// (baker/base/portable_math.h). tests/cli/test_libm.py compares variants of the native library.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, test } from 'node:test';
import { glbOf } from './small_scene.mjs';

const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-portable-'));
after(() => fs.rmSync(folder, { recursive: true }));

const native = (...command) => execFileSync(process.env.VXS, command, { cwd: folder, stdio: 'ignore' });
const wasm = (...command) =>
  execFileSync(process.execPath, [path.join(process.env.VXS_PACKAGE, 'bin/vxs.mjs'), ...command], { cwd: folder, stdio: 'ignore' });
const bytes = (name) => fs.readFileSync(path.join(folder, name));

function bakesAlike(scene, ...options) {
  native('bake', scene, '-o', 'native.vxs', '--force', '--quiet', ...options);
  wasm('bake', scene, '-o', 'wasm.vxs', '--force', '--quiet', ...options);
  assert.ok(bytes('native.vxs').equals(bytes('wasm.vxs')), `${scene}: bytes differ`);
}

test('lamps with 200 different cones, places and directions', () => {
  const unit = (v) => v.map((x) => x / Math.sqrt(v.reduce((sum, y) => sum + y * y, 0)));
  fs.writeFileSync(path.join(folder, 'lamps.glb'), glbOf([[-8, -1, -8, 8, 0, 8], [-1, 2, -1, 1, 3, 1]], Array.from({ length: 200 }, (_, n) => ({
    type: n % 5 ? 'spot' : 'point', name: `lamp ${n}`, position: [0.13 * (n % 9), 6 + 0.37 * (n % 7), 0.1], ...(n % 5 && {
      rotation: unit([-1, 0.01 * n - 1, 0.3, 1]), spot: { innerConeAngle: 0, outerConeAngle: 0.1 + 0.0071 * n } }),
  }))));
  bakesAlike('lamps.glb', '--resolution', '64');
});

const SCENES = {
  city: [['city', '--triangles', '10000'], ['--resolution', '512']],
  spots: [['city', '--spots', '40'], ['--resolution', '128']],
  room: [['room', '--triangles', '20000'], ['--resolution', '256']],
  smoke: [['smoke', '--capsules', '2000'], ['--resolution', '128', '--scene-smoke', 'on', '--smoke-side', '64']],
};

for (const [name, [kind, options]] of Object.entries(SCENES))
  test(`a generated scene: ${name}`, () => {
    native('scene', ...kind, '-o', `${name}.glb`, '--quiet');
    bakesAlike(`${name}.glb`, ...options);
  });
