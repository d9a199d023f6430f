// The native library and command, beside which the runtime as WebAssembly is tested.
// SPDX-License-Identifier: GPL-3.0-or-later
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

import { pillars } from './small_scene.mjs';

export const VXS = process.env.VXS ?? path.resolve('build/release/vxs');
export const PACKAGE = process.env.VXS_PACKAGE ?? path.resolve('build/web/vxs');
export const ANSWERS = path.join(path.dirname(VXS), 'tests/web/answers');
export const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-runtime-'));
process.on('exit', () => fs.rmSync(folder, { recursive: true }));

export const runtime = (module = 'vxs.mjs') => import(pathToFileURL(path.join(PACKAGE, 'runtime', module)));
const run = (program, args, options) =>
  execFileSync(program, args, { maxBuffer: 1 << 30, stdio: ['pipe', 'pipe', 'inherit'], ...options });

/** Path of a file baked with options from a scene: 'pillars', or what `vxs scene` makes. */
export function baked(name, scene, options) {
  const glb = path.join(folder, `${scene}.glb`), vxs = path.join(folder, `${name}.vxs`);
  if (!fs.existsSync(glb)) {
    if (scene === 'pillars') fs.writeFileSync(glb, pillars());
    else run(VXS, ['scene', scene, '--quiet', '-o', glb]);
  }
  if (!fs.existsSync(vxs)) run(VXS, ['bake', glb, '-o', vxs, '--quiet', ...options]);
  return vxs;
}

/** Random numbers in [0, 1), the same on each run. */
export function randomly(seed = 1) {
  return () => (seed = seed * 48271 % 2147483647) / 2147483647;
}

/** Points with normals, six numbers each: in space, at the borders of shadows, outside of all volumes, not numbers. */
export function pointsFor(lights, count, random = randomly()) {
  const list = new Float64Array(6 * count), wild = [NaN, Infinity, -Infinity, 1e300, -1e18, 0];
  for (let n = 0; n < count; n++) {
    const light = lights[n % lights.length], map = Math.floor(random() * light.maps), side = light.resolution;
    const u = (1.2 * random() - 0.1) * side, v = (1.2 * random() - 0.1) * side, inside = u >= 0 && v >= 0 && u < side && v < side;
    const near = inside ? light.firstShadow(map, Math.floor(u), Math.floor(v)) + 6 * random() - 3 : 1.2 * side * random();
    const point = light.point(map, [u, v, n % 3 ? near : 1.2 * side * random()]);
    if (n % 97 === 0) point[n % 3] = wild[n % wild.length];
    list.set(point, 6 * n);
    list.set([0, 1, 2].map((axis) => n % 89 === axis ? 0 : 2 * random() - 1), 6 * n + 3);
  }
  return list;
}

/** What C answers for a file: a map from names to bytes. */
export function answers(file, points) {
  const bytes = run(ANSWERS, ['ask', file], { input: new Uint8Array(points.buffer) }), found = new Map();
  for (let at = 0; at < bytes.length;) {
    const name = bytes.toString('latin1', at, bytes.indexOf(0, at)), size = Number(bytes.readBigUInt64LE(at + 32));
    found.set(name, bytes.subarray(at + 40, at + 40 + size));
    at += 40 + size;
  }
  return found;
}

/** Results of C for files: { result, finding, section, offset }. */
export function openings(files) {
  return run(ANSWERS, ['open', ...files]).toString().trim().split('\n').map((line) => {
    const [result, finding, section, offset] = line.split(' ').map(Number);
    return { result, finding, section, offset };
  });
}
