// vxs/three in Chromium, in the newest and the oldest release of three.js that it supports: pictures against `vxs render`.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { RELEASES, launch, noBrowser, openPage, run, serve } from './browser.mjs';

const VXS = process.env.VXS ?? new URL('../../build/release/vxs', import.meta.url).pathname;
const skip = noBrowser || (!fs.existsSync(VXS) && `no command at ${VXS}: make`);
const PAGE = '/tests/three_page.mjs', SIZE = [320, 240];
const VIEWS = {
  city: { eye: [-150, 90, -160], target: [0, 0, 0], fov: 50 },
  room: { eye: [3, 1.8, 2.2], target: [-1, 0.8, -0.5], fov: 70 },
};
let folder, server, browser;
const vxs = (...args) => execFileSync(VXS, args, { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });

before(async () => {
  if (skip) return;
  folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-three-'));
  for (const [scene, resolution] of [['city', 4096], ['room', 1024]]) {
    vxs('scene', scene, '-o', `${scene}.glb`);
    vxs('bake', `${scene}.glb`, '-o', `${scene}.vxs`, '--resolution', `${resolution}`);
    const { eye, target, fov } = VIEWS[scene];
    for (const filter of ['9', '3'])
      vxs('render', `${scene}.glb`, `${scene}.vxs`, '-o', 'out.png', '--width', `${SIZE[0]}`, '--height', `${SIZE[1]}`, '--samples', '1',
        `--eye=${eye}`, `--target=${target}`, '--fov', `${fov}`, '--filter', filter, '--passes', `${scene}-${filter}`);
  }
  server = await serve(folder);
  browser = await launch();
});

after(async () => {
  await browser?.close();
  await server?.close();
  if (folder) fs.rmSync(folder, { recursive: true });
});

/** A test in a page of each release; what the console reports fails it. */
function inBrowser(name, act, options = {}) {
  for (const three of options.releases ?? RELEASES)
    test(`${name} (${three})`, { skip }, async () => {
      const page = await openPage(browser, server, { three, ...options });
      try {
        await act(page, three);
        assert.deepEqual(page.faults, []);
      } finally {
        await page.close();
      }
    });
}

const files = (scene) => ({ glb: `/files/${scene}.glb`, vxs: `/files/${scene}.vxs`, view: VIEWS[scene], size: SIZE });

inBrowser('lookups give the pictures of vxs render', async (page) => {
  for (const [scene, light, pass] of [['city', 'sun', 'lit-0-sun'], ['room', 'lamp', 'lit-0-lamp'], ['room', 'corner', 'lit-1-corner']]) {
    const got = await run(page, PAGE, 'compared', { ...files(scene), light, pass: `/files/${scene}-9/${pass}.png` });
    assert.deepEqual(got.matched.map(([, baked, moved]) => [baked, moved]), scene === 'city' ? [['sun', false]] : [['lamp', false], ['corner', false]]);
    assert.ok(got.pixels > 10000, `${scene}: ${got.pixels} pixels`);
    assert.ok(got.mean < 0.004 && got.beyond[2] < 0.002, `${scene} ${light}: ${JSON.stringify(got)}`);
  }
});

inBrowser('depth textures give nearly the same, without a shadow pass', async (page, three) => {
  for (const [scene, light, pass] of [['city', 'sun', 'lit-0-sun'], ['room', 'corner', 'lit-1-corner'], ['room', 'lamp', 'lit-0-lamp']]) {
    const given = { ...files(scene), light, pass: `/files/${scene}-3/${pass}.png`, attach: { way: 'depth' } };
    if (scene === 'room' && three !== 'three') { // its point light
      await assert.rejects(run(page, PAGE, 'compared', given), /r182 or later/);
      continue;
    }
    const got = await run(page, PAGE, 'compared', given);
    assert.ok(got.calls <= got.meshes, `${got.calls} calls for ${got.meshes} meshes`);
    assert.ok(got.mean < 0.05 && got.beyond[2] < 0.03, `${scene} ${light}: ${JSON.stringify(got)}`);
  }
});
