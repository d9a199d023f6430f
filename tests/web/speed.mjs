// How long the runtime as WebAssembly takes beside the C library, in time of the processor: node tests/web/speed.mjs [FILE.vxs]
// SPDX-License-Identifier: GPL-3.0-or-later
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';

import { ANSWERS, baked, runtime } from './native.mjs';

const ROUNDS = 15, COUNT = 20000, WIDE = 160;
const file = process.argv[2] ?? baked('city', 'city', ['--resolution', '4096']), bytes = fs.readFileSync(file);
const now = () => { const { user, system } = process.cpuUsage(); return (user + system) / 1000; };
const time = (call) => { const begin = now(); call(); return now() - begin; };
const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];

const { load } = await runtime(), began = performance.now(), vxs = await load(), loaded = performance.now();
let asset = vxs.open(bytes);
console.log(`load ${(loaded - began).toFixed(1)} ms, first open ${(performance.now() - loaded).toFixed(1)} ms`);

// neighbouring pixels on the surfaces of a level
const places = new Float64Array(6 * COUNT), light = asset.lights[0];
for (let n = 0; n < COUNT; n++) {
  const u = light.resolution * 0.4 + 0.6 * (n % WIDE), v = light.resolution * 0.4 + 0.6 * Math.floor(n / WIDE);
  places.set(light.point(0, [u, v, light.firstShadow(0, Math.floor(u), Math.floor(v)) - 0.5]), 6 * n);
}
const packed = places.filter((_, n) => n % 6 < 3), points = Array.from({ length: COUNT }, (_, n) => packed.slice(3 * n, 3 * n + 3));
const found = [[], [], [], [], []], ns = (ms) => 1e6 * ms / COUNT, native = [[], [], [], [], []];
for (let r = 0; r < ROUNDS; r++) {
  found[0].push(time(() => { asset.dispose(); asset = vxs.open(bytes); }));
  [undefined, 9].forEach((filter, k) => {
    found[1 + k].push(ns(time(() => { for (const p of points) asset.lights[0].lookup(p, { filter }); })));
    found[3 + k].push(ns(time(() => asset.lights[0].lookupMany(packed, { filter }))));
  });
  if (r % 5 === 0) {
    const line = execFileSync(ANSWERS, ['time', file], { input: new Uint8Array(places.buffer) }).toString().trim().split(' ');
    line.forEach((number, k) => native[k].push(+number));
  }
}
['open, ms', 'lookup 1 x 1, ns', 'lookup 9 x 9, ns', 'many 1 x 1, ns', 'many 9 x 9, ns'].forEach((name, k) => {
  const [web, c] = [median(found[k]), median(native[k])];
  console.log(`${name.padEnd(18)} ${web.toFixed(1).padStart(7)}  C ${c.toFixed(1).padStart(7)}  ratio ${(web / c).toFixed(2)}`);
});
