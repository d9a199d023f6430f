// tests/bench/web_compare.mjs on a small level, and its lightmaps.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { lightmapOf } from '../bench/web_compare_lightmap.mjs';
import { noBrowser } from './browser.mjs';
import { pillars } from './small_scene.mjs';

/** Corners of a box of 4 x 2 x 3 m, [9 * 12]. */
function box() {
  const at = (c) => [(c & 1) * 4, ((c >> 1) & 1) * 2, (c >> 2) * 3];
  const faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
  return Float32Array.from(faces.flatMap(([a, b, c, d]) => [a, b, c, a, c, d].flatMap(at)));
}

test('a lightmap has the light of each place of its surface, within a texel, and no texel of another chart', () => {
  const soup = box(), isLit = (p) => (p[0] + p[1] > 2.3 ? 1 : 0);
  const map = lightmapOf(soup, 128 * 128, (points) => Array.from({ length: points.length / 6 }, (_, n) => isLit(points.slice(6 * n, 6 * n + 3))));
  assert.equal(map.side, 128);
  assert.ok(map.metres < 0.1, `${map.metres} m a texel: the charts do not fill the map`);
  const texel = (x, y) => map.texels[Math.min(Math.max(x, 0), 127) + 128 * Math.min(Math.max(y, 0), 127)] / 255;
  let asked = 0;
  for (let t = 0; t < 12; t++)
    for (let n = 1; n < 400; n++) {
      const u = ((n * 7919) % 400) / 400, v = ((n * 104729) % 400) / 400, w = u + v > 1 ? [1 - u, 1 - v] : [u, v], weights = [1 - w[0] - w[1], ...w];
      const mix = (from, size, axis) => weights.reduce((sum, b, k) => sum + b * from[3 * size * t + size * k + axis], 0);
      const p = [0, 1, 2].map((axis) => mix(soup, 3, axis)), [x, y] = [0, 1].map((axis) => (mix(map.uvs, 2, axis) / 65535) * 128 - 0.5);
      const [i, j] = [Math.floor(x), Math.floor(y)], a = x - i, b = y - j;
      const got = (1 - b) * ((1 - a) * texel(i, j) + a * texel(i + 1, j)) + b * ((1 - a) * texel(i, j + 1) + a * texel(i + 1, j + 1));
      if (Math.abs(p[0] + p[1] - 2.3) < 3 * map.metres) continue; // near the edge of the light
      asked++;
      assert.ok(Math.abs(got - isLit(p)) < 0.004, `${p}: ${got}`); // texture coordinates have 16 bits: 0.002 texel
    }
  assert.ok(asked > 3000);
  assert.equal(lightmapOf(soup, 4, () => []), null); // more charts than texels
});

test('a level of a user is compared: each way is nearer to the rays than no shadow is', { skip: noBrowser }, () => {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-compare-'));
  try {
    fs.writeFileSync(path.join(folder, 'pillars.glb'), pillars());
    execFileSync(process.execPath, [fileURLToPath(new URL('../bench/web_compare.mjs', import.meta.url)), '-o', folder, '--level', path.join(folder, 'pillars.glb'),
      '--sun', '0.8,-1,0.5', '--eye', '7,5,7', '--target', '0,0.5,0', '--size', '96x54', '--ways', 'PCF 2048|vxs 4096'], { stdio: 'pipe' });
    const { scenes: [scene] } = JSON.parse(fs.readFileSync(path.join(folder, 'compare.json'), 'utf8')), page = fs.readFileSync(path.join(folder, 'index.html'), 'utf8');
    const schema = fileURLToPath(new URL('../../docs/web-compare.schema.json', import.meta.url));
    execFileSync('/usr/bin/python3', ['-W', 'ignore', '-m', 'jsonschema', '-i', path.join(folder, 'compare.json'), schema], { stdio: 'pipe' });
    const dark = 1 - scene.lit, of = (name) => scene.ways.find(({ way }) => way === name);
    assert.ok(scene.pixels > 2000 && dark > 0.05, `${scene.pixels} pixels, ${dark} of them dark`);
    assert.deepEqual(scene.ways.map(({ way }) => way), ['three PCF 2048', 'vxs 4096, depth', 'vxs 4096, 1 x 1', 'vxs 4096, 3 x 3', 'lightmap of the bytes of vxs 4096']);
    for (const { way, mean_error: error, wrong, gpu_bytes: bytes, picture } of scene.ways) {
      assert.ok(error < 0.5 * dark && wrong <= 2 * error && bytes > 0, `${way}: ${error}, ${wrong} wrong, ${bytes} bytes; ${dark} of the pixels are dark`);
      assert.ok(page.includes(picture) && fs.readFileSync(path.join(folder, picture)).subarray(1, 4).toString() === 'PNG', picture);
    }
    assert.ok(of('vxs 4096, 1 x 1').mean_error < 0.01);
    assert.ok(of('vxs 4096, depth').normal_bias_texels > 0); // they matter
    const [live, depth, lookup] = scene.ways;
    assert.ok(live.draw_calls > depth.draw_calls && live.gpu_bytes > lookup.gpu_bytes);
  } finally {
    fs.rmSync(folder, { recursive: true });
  }
});
