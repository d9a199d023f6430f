// vxs/three/webgpu in Chromium: both backends of WebGPURenderer, in the newest release of three.js.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { launch, noBrowser, openPage, run, serve } from './browser.mjs';
import { pillars } from './small_scene.mjs';

const VXS = process.env.VXS ?? new URL('../../build/release/vxs', import.meta.url).pathname;
const skip = noBrowser || (!fs.existsSync(VXS) && `no command at ${VXS}: make`);
const VIEW = { eye: [3, 1.8, 2.2], target: [-1, 0.8, -0.5], fov: 70 }, SIZE = [320, 240];
let folder, server, browser;
const hasAdapter = (page) => page.evaluate(async () => !!(await navigator.gpu?.requestAdapter()));

before(async () => {
  if (skip) return;
  folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-webgpu-'));
  const vxs = (...args) => execFileSync(VXS, args, { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  fs.writeFileSync(path.join(folder, 'pillars.glb'), pillars());
  vxs('bake', 'pillars.glb', '-o', 'pillars.vxs', '--resolution', '1024');
  vxs('scene', 'room', '-o', 'room.glb');
  vxs('bake', 'room.glb', '-o', 'room.vxs', '--resolution', '1024');
  vxs('render', 'room.glb', 'room.vxs', '-o', 'out.png', '--width', `${SIZE[0]}`, '--height', `${SIZE[1]}`, '--samples', '1', `--eye=${VIEW.eye}`,
    `--target=${VIEW.target}`, '--fov', `${VIEW.fov}`, '--filter', '9', '--passes', 'passes');
  server = await serve(folder);
  browser = await launch({ args: ['--enable-unsafe-webgpu', '--use-webgpu-adapter=swiftshader'] });
});

after(async () => {
  await browser?.close();
  await server?.close();
  if (folder) fs.rmSync(folder, { recursive: true });
});

for (const backend of ['webgl', 'webgpu'])
  test(`shadow nodes give the pictures of vxs render (${backend})`, { skip }, async (t) => {
    const page = await openPage(browser, server, { webgpu: true });
    try {
      if (backend === 'webgpu' && !(await hasAdapter(page))) return t.skip('this browser has no WebGPU adapter');
      for (const [light, pass, movers] of [['lamp', 'lit-0-lamp', false], ['corner', 'lit-1-corner', false], ['corner', 'lit-1-corner', true]]) {
        const got = await run(page, '/tests/webgpu_page.mjs', 'compared',
          { glb: '/files/room.glb', vxs: '/files/room.vxs', view: VIEW, size: SIZE, light, pass: `/files/passes/${pass}.png`, backend, movers });
        const text = `${light}: ${JSON.stringify(got)}`;
        assert.equal(got.webgpu, backend === 'webgpu');
        assert.ok(got.restored && got.nodes === 0 && got.matched === 2 && got.pixels > 10000, text);
        if (movers) assert.ok(got.thrown > 500, text); // a ball throws a shadow that is not in the file
        else assert.ok(got.mean < 0.004 && got.most < 0.002, text);
      }
      assert.deepEqual(page.faults, []);
    } finally {
      await page.close();
    }
  });

for (const backend of ['webgl', 'webgpu'])
  test(`depth maps give the pictures of WebGLRenderer (${backend})`, { skip }, async (t) => {
    const given = { glb: '/files/pillars.glb', vxs: '/files/pillars.vxs', view: { eye: [7, 6, 9], target: [0, 0.5, 0], fov: 60 }, size: SIZE, attach: { way: 'depth' } };
    const plain = await openPage(browser, server), page = await openPage(browser, server, { webgpu: true });
    try {
      if (backend === 'webgpu' && !(await hasAdapter(page))) return t.skip('this browser has no WebGPU adapter');
      for (const [light, type, limit, options] of [['sun', 'BasicShadowMap', 0.0005], ['spot', 'BasicShadowMap', 0.0005], ['lamp', 'BasicShadowMap', 0.0005],
        ['lamp', 'PCFShadowMap', 0.002], ['spot', 'BasicShadowMap', 0.0005, { reversedDepthBuffer: true }]]) {
        const wanted = Object.values((await run(plain, '/tests/three_page.mjs', 'litPixels', { ...given, light, type })).lit);
        const lit = await run(page, '/tests/webgpu_page.mjs', 'litPixels', { ...given, light, type, backend, options });
        let pixels = 0, sum = 0, dark = 0;
        wanted.forEach((x, n) => {
          if (!Number.isFinite(x) || !Number.isFinite(lit[n])) return;
          pixels++;
          sum += Math.abs(x - lit[n]);
          if (x < 0.5) dark++;
        });
        assert.ok(pixels > 20000 && dark > 1000 && sum < limit * pixels, `${light}, ${type}: ${sum / pixels} of ${pixels} pixels; ${dark} are dark`);
      }
      assert.deepEqual([...plain.faults, ...page.faults], []);
    } finally {
      await plain.close();
      await page.close();
    }
  });

for (const backend of ['webgl', 'webgpu'])
  test(`filters, ways and live shadows change at once (${backend})`, { skip }, async (t) => {
    const page = await openPage(browser, server, { webgpu: true });
    try {
      if (backend === 'webgpu' && !(await hasAdapter(page))) return t.skip('this browser has no WebGPU adapter');
      const sums = await run(page, '/tests/webgpu_page.mjs', 'changes', { glb: '/files/room.glb', vxs: '/files/room.vxs', view: VIEW, size: [160, 120], light: 'lamp', backend });
      const { none, narrow, wide, depth, live } = sums, text = JSON.stringify(sums);
      assert.equal(new Set([none, narrow, wide, depth, live]).size, 5, text);
      assert.deepEqual([sums['none again'], sums['narrow again'], sums['narrow over live'], sums['depth over live'], sums['live again']], [none, narrow, narrow, depth, live], text);
      for (const each of [narrow, wide, depth]) assert.ok(each < 0.6 * none && Math.abs(each / narrow - 1) < 0.02, text);
      assert.deepEqual(page.faults, []);
    } finally {
      await page.close();
    }
  });

for (const backend of ['webgl', 'webgpu'])
  test(`fog is that of WebGLRenderer (${backend})`, { skip }, async (t) => {
    const medium = { extinction: 0.2, scattering: 0.15, anisotropy: 0.5 }, given = { glb: '/files/room.glb', vxs: '/files/room.vxs', view: VIEW, size: [160, 120], medium };
    const plain = await openPage(browser, server), page = await openPage(browser, server, { webgpu: true });
    try {
      if (backend === 'webgpu' && !(await hasAdapter(page))) return t.skip('this browser has no WebGPU adapter');
      const wanted = {}, sum = (values) => values.reduce((a, b) => a + b, 0);
      const apart = (a, b) => sum(a.map((x, n) => Math.abs(x - b[n]))) / sum(b);
      for (const light of ['lamp', 'corner']) {
        wanted[light] = await run(plain, '/tests/three_page.mjs', 'fogPicture', { ...given, light });
        const got = await run(page, '/tests/webgpu_page.mjs', 'fogPicture', { ...given, light, backend });
        assert.ok(sum(wanted[light]) > 1 && apart(got, wanted[light]) < 0.002, `${light}: ${apart(got, wanted[light])}`);
      }
      // one behind the other: the second dims the airlight of the first
      const both = await run(page, '/tests/webgpu_page.mjs', 'fogPicture', { ...given, lights: ['lamp', 'corner'], medium: { ...medium, transmits: false }, backend });
      assert.ok(apart(both, wanted.lamp.map((x, n) => x + wanted.corner[n])) < 0.002);
      assert.deepEqual([...plain.faults, ...page.faults], []);
    } finally {
      await plain.close();
      await page.close();
    }
  });
