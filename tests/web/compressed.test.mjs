// Levels with compressed meshes and textures, baked, loaded by three.js, and in the page of vxs view. tests/web/levels holds the level of
// small_scene.mjs as glTF-Transform 4.5 writes it: draco.glb and meshopt.glb (both of 14 bits), and ktx2.glb (ETC1S), whose texture is red
// where x < 0 and blue elsewhere.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { launch, noBrowser, openPage, run, serve } from './browser.mjs';
import { pillars } from './small_scene.mjs';

const fileOf = (name) => fileURLToPath(new URL(name, import.meta.url));
const VXS = process.env.VXS ?? fileOf('../../build/release/vxs'), PACKAGE = process.env.VXS_PACKAGE ?? fileOf('../../build/web/vxs');
const TEMPLATE = path.join(PACKAGE, '../view.html');
const missing = [[VXS, 'make'], [TEMPLATE, 'make web']].find(([file]) => !fs.existsSync(file));
const skip = noBrowser || (missing && `no ${missing[0]}: ${missing[1]}`);
const NAMES = ['sun', 'spot', 'lamp'];
const GIVEN = { view: { eye: [0, 14, 7], target: [0, 0, 0], fov: 60 }, size: [160, 120], light: 'sun', libraries: '/lib/three/examples/jsm/libs' };
let folder, server, browser, page, plain;

const level = (name) => ({ glb: `/files/${name}.glb`, vxs: `/files/${name}.vxs` });
before(async () => {
  if (skip) return;
  folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-compressed-'));
  fs.cpSync(fileOf('levels'), folder, { recursive: true });
  fs.writeFileSync(path.join(folder, 'plain.glb'), pillars());
  const vxs = (...args) => execFileSync(VXS, args, { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  for (const name of ['plain', 'draco', 'meshopt', 'ktx2'])
    vxs('bake', `${name}.glb`, '-o', `${name}.vxs`, '--resolution', '512', '--quiet');
  for (const name of ['draco', 'meshopt', 'ktx2']) vxs('view', `${name}.glb`, `${name}.vxs`, '-o', `${name}.html`, '--page', TEMPLATE);
  [server, browser] = [await serve(folder), await launch()];
  page = await openPage(browser, server);
  plain = await run(page, '/tests/compressed_page.mjs', 'drawn', { ...GIVEN, ...level('plain') });
});

after(async () => {
  await browser?.close();
  await server?.close();
  if (folder) fs.rmSync(folder, { recursive: true });
});

for (const name of ['draco', 'meshopt', 'ktx2']) {
  test(`${name}: in three.js, shadows are those of the level as it was`, { skip }, async () => {
    const got = await run(page, '/tests/compressed_page.mjs', 'drawn', { ...GIVEN, ...level(name) });
    assert.deepEqual(got.matched.sort(), NAMES.map((light) => [light, false]).sort());
    let pixels = 0, dark = 0, apart = 0;
    plain.shares.forEach((share, n) => {
      if (share < 0) return;
      pixels++;
      if (share < 0.5) dark++;
      if (Math.abs(share - got.shares[n]) > 0.2) apart++; // edges move by a part of a texel
    });
    assert.ok(pixels > 5000 && dark > 300 && apart < 0.01 * pixels, `${apart} of ${pixels} pixels differ; ${dark} are dark`);
    if (name === 'ktx2') {
      const [left, right] = [0, 1].map((half) => [0, 2].map((channel) => got.colours.reduce(
        (sum, x, n) => sum + (n % 3 === channel && (Math.floor(n / 3) % 160 < 80 ? 0 : 1) === half ? x : 0), 0)));
      assert.ok(left[0] > 10 * left[1] && right[1] > 10 * right[0], `red and blue, left: ${left}; right: ${right}`);
    }
    assert.deepEqual(page.faults, []);
  });

  test(`${name}: in vxs view, from a file and without a network`, { skip }, async () => {
    const opened = await browser.newPage(), faults = [], url = pathToFileURL(path.join(folder, `${name}.html`)).href;
    opened.on('console', (message) => ['error', 'warn', 'warning'].includes(message.type()) && faults.push(message.text()));
    opened.on('pageerror', (error) => faults.push(error.message));
    opened.on('request', (request) => request.url() === url || /^(data|blob):/.test(request.url()) || faults.push(request.url()));
    try {
      await opened.goto(url);
      const got = await opened.evaluate(async () => {
        await globalThis.vxsView.ready;
        const { root, stage } = globalThis.vxsView, size = stage.bounds.getSize(stage.camera.position.clone()).toArray();
        let triangles = 0, image = null;
        root.traverse((object) => {
          if (object.isMesh) triangles += object.geometry.index.count / 3;
          image ??= object.material?.map ?? null;
        });
        const lights = stage.lights.map(({ baked }) => baked?.name);
        return { triangles, size, lights, image: image && [image.image.width, image.image.height] };
      });
      assert.deepEqual(got.lights.sort(), [...NAMES].sort());
      assert.equal(got.triangles, 60);
      got.size.forEach((metres, axis) => assert.ok(Math.abs(metres - [16, 5.5, 16][axis]) < 0.01, `${got.size}`));
      assert.deepEqual(got.image, name === 'ktx2' ? [16, 16] : null);
      assert.deepEqual(faults, []);
    } finally {
      await opened.close();
    }
  });
}
