// vxs/three in Chromium, in the newest and the oldest release of three.js that it supports: pictures against `vxs render`.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { hall, pillars } from './small_scene.mjs';
import { RELEASES, launch, noBrowser, openPage, run, serve } from './browser.mjs';

const VXS = process.env.VXS ?? new URL('../../build/release/vxs', import.meta.url).pathname;
const skip = noBrowser || (!fs.existsSync(VXS) && `no command at ${VXS}: make`);
const ALL = process.env.VXS_TEST_REPEATS === 'all', SOME = ALL ? RELEASES : ['three'];
const PAGE = '/tests/three_page.mjs', SIZE = [320, 240];
const VIEWS = {
  city: { eye: [-150, 90, -160], target: [0, 0, 0], fov: 50 },
  room: { eye: [3, 1.8, 2.2], target: [-1, 0.8, -0.5], fov: 70 },
  pillars: { eye: [9, 9, 11], target: [0, 0, 0], fov: 45 },
  hall: { eye: [14, 9, 13], target: [0, 0, 0], fov: 50 },
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
  for (const [name, bytes, resolution] of [['pillars', pillars(), 1024], ['hall', hall(), 512]]) {
    fs.writeFileSync(path.join(folder, `${name}.glb`), bytes);
    vxs('bake', `${name}.glb`, '-o', `${name}.vxs`, '--resolution', `${resolution}`, '--quiet');
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
    test(`${name} (${three})`, { skip: skip || options.skip }, async () => {
      const page = await openPage(browser, server, { three, ...options });
      try {
        await act(page, three);
        assert.deepEqual(page.faults, []);
      } finally {
        await page.close();
      }
    });
}

const files = (scene, size = SIZE) => ({ glb: `/files/${scene}.glb`, vxs: `/files/${scene}.vxs`, view: VIEWS[scene], size });
const SMALL = [80, 60];

inBrowser('lights match by kind and name, then by place', async (page) => {
  assert.deepEqual(await run(page, PAGE, 'matching'), {
    matched: [['', 'light3', false], ['My_Lamp', 'My Lamp', false], ['lamp', 'lamp', false], ['lamp_1', 'lamp#2', false], ['moved', 'moved', true]],
    lights: ['live', 'sun'], baked: ['sun'],
  });
}, { releases: SOME });

inBrowser('lookups give the pictures of vxs render', async (page) => {
  for (const [scene, light, pass] of [['city', 'sun', 'lit-0-sun'], ['room', 'lamp', 'lit-0-lamp'], ['room', 'corner', 'lit-1-corner']]) {
    const got = await run(page, PAGE, 'compared', { ...files(scene), light, pass: `/files/${scene}-9/${pass}.png` });
    assert.deepEqual(got.matched.map(([, baked, moved]) => [baked, moved]), scene === 'city' ? [['sun', false]] : [['lamp', false], ['corner', false]]);
    assert.ok(got.pixels > 10000, `${scene}: ${got.pixels} pixels`);
    assert.ok(got.mean < 0.004 && got.beyond[2] < 0.002, `${scene} ${light}: ${JSON.stringify(got)}`);
  }
});

inBrowser('single taps are those of vxs query, and nearly those of rays', async (page) => {
  const rows = await run(page, PAGE, 'points', { ...files('city'), light: 'sun' });
  const input = rows.map((row) => row.slice(0, 6).join(' ')).join('\n');
  const ask = (...args) => execFileSync(VXS, args, { cwd: folder, input, encoding: 'utf8' }).trim().split('\n').map(Number);
  const share = (wanted) => rows.filter((row, n) => Math.abs(row[6] - wanted[n]) > 0.01).length / rows.length;
  const query = share(ask('query', 'city.vxs', '--filter', '1')), truth = share(ask('truth', 'city.glb', '--light', 'sun'));
  assert.ok(rows.length > 500 && query < 0.02 && truth < 0.05, `${rows.length} points, ${query} from query, ${truth} from rays`);
}, { releases: SOME });

const KAYKIT = path.join(process.env.VXS_SCENES ?? new URL('../../../shared/scenes', import.meta.url).pathname, 'real/kaykit_city.glb');
inBrowser('a real scene, in light that was given to its bake', async (page) => {
  const view = { eye: [-9, 7, 11], target: [1, 0, 0], fov: 45 }, glb = '/files/kaykit.glb', given = { ...files('kaykit'), glb, view };
  fs.copyFileSync(KAYKIT, path.join(folder, 'kaykit.glb'));
  vxs('bake', 'kaykit.glb', '-o', 'kaykit.vxs', '--resolution', '4096', '--sun=-0.4,-1,-0.3', '--quiet');
  for (const [way, filter, limit] of [['lookup', '9', 0.004], ['depth', '3', 0.02]]) {
    vxs('render', 'kaykit.glb', 'kaykit.vxs', '-o', 'out.png', '--width', `${SIZE[0]}`, '--height', `${SIZE[1]}`, '--samples', '1',
      `--eye=${view.eye}`, `--target=${view.target}`, '--fov', `${view.fov}`, '--filter', filter, '--passes', 'kaykit');
    const got = await run(page, PAGE, 'compared', { ...given, attach: { way }, pass: '/files/kaykit/lit-0-sun.png' });
    assert.deepEqual(got.matched, [['sun', 'sun', false]]);
    assert.ok(got.pixels > 10000 && got.mean < limit && got.beyond[2] < 0.005, JSON.stringify(got));
  }
}, { releases: SOME, skip: !fs.existsSync(KAYKIT) && `no ${KAYKIT}: set VXS_SCENES` });

inBrowser('depth textures give nearly the same, without a shadow pass', async (page, three) => {
  for (const [scene, light, pass] of [['city', 'sun', 'lit-0-sun'], ['room', 'corner', 'lit-1-corner'], ['room', 'lamp', 'lit-0-lamp']]) {
    const given = { ...files(scene), light, pass: `/files/${scene}-3/${pass}.png`, attach: { way: 'depth' } };
    if (scene === 'room' && three !== 'three') { // its point light
      await assert.rejects(run(page, PAGE, 'compared', given), /r182 or later/);
      continue;
    }
    const got = await run(page, PAGE, 'compared', given);
    assert.ok(got.calls <= got.meshes, `${got.calls} calls for ${got.meshes} meshes`);
    assert.ok(got.mean < 0.02 && got.beyond[2] < 0.01, `${scene} ${light}: ${JSON.stringify(got)}`);
  }
  const hard = await run(page, PAGE, 'compared', { ...files('city'), pass: '/files/city-3/lit-0-sun.png', attach: { way: 'depth' }, type: 'BasicShadowMap' });
  assert.ok(hard.mean < 0.03 && hard.beyond[2] < 0.02, JSON.stringify(hard));
  if (three === 'three') { // r182 and later may have depths that fall with distance
    const options = { reversedDepthBuffer: true }, given = { ...files('room'), light: 'lamp', attach: { way: 'depth' }, options };
    const got = await run(page, PAGE, 'compared', { ...given, pass: '/files/room-3/lit-0-lamp.png' });
    assert.ok(got.mean < 0.02 && got.beyond[2] < 0.01, JSON.stringify(got));
  }
});

inBrowser('integer voxels are those of the runtime, to the bit', async (page) => {
  for (const [scene, light] of [['city', 'sun'], ['room', 'lamp'], ['room', 'corner']])
    for (const [width, smooth] of ALL ? [[1], [3], [9], [17], [9, true], [8, true]] : [[1], [9], [8, true]]) {
      const got = await run(page, PAGE, 'voxels', { ...files(scene), light, width, smooth });
      assert.equal(got.wrong, 0, `${scene} ${light} ${width}: ${JSON.stringify(got)}`);
      assert.ok(got.outside < got.count / 2 && (width === 1 || got.partial > 100), JSON.stringify(got));
    }
}, { releases: SOME });

inBrowser('a scene 100 km from the origin looks the same', async (page) => {
  const got = await run(page, PAGE, 'farAway', { ...files('city', [160, 120]), light: 'sun', offset: [1e5, 0, 1e5] });
  assert.ok(got.mean > 0.1 && got.differ < 0.001, JSON.stringify(got));
}, { releases: SOME });

inBrowser('all kinds of materials and meshes have the same shadow', async (page) => {
  const { out, dark, lit } = await run(page, PAGE, 'kinds', files('pillars', SMALL));
  for (const [kind, apart] of Object.entries(out)) assert.ok(apart < 0.002, `${kind}: ${apart}`);
  assert.ok(dark > 0.01 && lit > 0.1, `${dark} ${lit}`);
}, { releases: SOME });

inBrowser('lights of all kinds shine together as they do alone', async (page) => {
  const got = await run(page, PAGE, 'manyLights', { ...files('pillars', [160, 120]), group: 1, live: true });
  assert.deepEqual([got.lights, got.matched], [4, 3]);
  assert.ok(got.apart < 1e-4 && got.mean < 0.99 * got.bare, JSON.stringify(got));
}, { releases: SOME });

inBrowser('165 lamps shine in one material', async (page) => {
  const got = await run(page, PAGE, 'manyLights', { ...files('hall', SMALL), group: 55 });
  assert.deepEqual([got.lights, got.matched], [165, 165]);
  assert.ok(got.apart < 1e-4 && got.mean > 0.1 && got.mean < 0.99 * got.bare, JSON.stringify(got));
}, { releases: SOME });

inBrowser('what moves casts into a live map, and nothing else does', async (page) => {
  const got = await run(page, PAGE, 'moving', files('pillars'));
  assert.ok(got.onlyDarker && got.changed > 20 && got.restored, JSON.stringify(got));
  assert.ok(got.calls <= got.stillCalls + 2, JSON.stringify(got)); // the ball, and its shadow where three.js counts it
}, { releases: SOME });

inBrowser('hooks that a material has stay, and come back', async (page) => {
  const { bare, shaded, untinted, again, shadedAgain, restored } = await run(page, PAGE, 'chained', files('pillars', SMALL));
  assert.ok(restored);
  assert.deepEqual([again, shadedAgain], [bare, shaded]);
  assert.ok(shaded[0] < 0.99 * bare[0] && shaded[1] === 0, JSON.stringify(shaded));
  assert.ok(Math.abs(untinted[1] - shaded[0]) < 1e-3 * shaded[0], JSON.stringify(untinted));
}, { releases: SOME });

inBrowser('loads and disposals leave nothing behind', async (page) => {
  for (const way of ['lookup', 'depth']) {
    const got = await run(page, PAGE, 'leaks', { ...files('pillars'), way, times: way === 'lookup' || ALL ? 1000 : 100 });
    assert.deepEqual(got.after, got.before, way);
    assert.ok(got.during > got.after.textures, way);
  }
}, { releases: SOME });

inBrowser('a lost context comes back', async (page) => {
  for (const way of ['lookup', 'depth']) {
    const got = await run(page, PAGE, 'lost', { ...files('pillars', SMALL), attach: { way } });
    assert.ok(got.differ === 0 && got.mean > 0.1, `${way} ${JSON.stringify(got)}`);
  }
}, { releases: SOME, allow: /Context (Lost|Restored)/i });

inBrowser('damaged files and wrong options are errors, and the scene stays as it was', async (page) => {
  const got = await run(page, PAGE, 'refused', files('pillars'));
  assert.match(got.damaged, /^true corrupt \d+ /);
  assert.match(got.truncated, /^true truncated \d+ /);
  assert.match(got.empty, /^true truncated \d+ /);
  assert.match(got.missing, /^false .*404/);
  for (const option of ['way', 'filter', 'renderer', 'scaled']) assert.match(got[option], /^true argument /, option);
  assert.match(got.vsm, /^true unsupported .*VSMShadowMap/);
  assert.match(got.twice, /shadows of another file/);
  assert.match(got['before detach'], /the scene has changed/);
  const heard = await run(page, PAGE, 'managed', files('pillars'));
  assert.deepEqual(heard, ['3 lights', 'all', 'truncated', 'failed', 'all', 'no file', 'failed', 'all']);
  for (const [name, text] of Object.entries(got)) if (name !== 'before detach') assert.doesNotMatch(text, /the scene has changed/, name);
}, { releases: SOME, allow: /nothing.vxs|404/ });

inBrowser('fog has the airlight of the lit intervals', async (page) => {
  const medium = { extinction: 0.08, scattering: 0.06, anisotropy: 0.5 }, view = { eye: [-7, 4, 9], target: [0, 1.5, 0], fov: 60 };
  vxs('bake', 'pillars.glb', '-o', 'dag.vxs', '--resolution', '1024', '--coding', 'dag', '--quiet');
  for (const [light, more] of [['sun', {}], ['spot', {}], ['lamp', {}], ['sun', { orthographic: true }], ['sun', { half: true }], ['lamp', { half: true }], ['spot', { vxs: '/files/dag.vxs' }]]) {
    const got = await run(page, PAGE, 'fog', { ...files('pillars', [160, 120]), view, light, medium, ...more });
    const text = `${light}: ${JSON.stringify(got)}`;
    assert.ok(got.count > 200 && got.mean > 0.005 && got.tables === !more.vxs, text);
    if (more.half) assert.ok(got.apart < 0.05 && got.apart > 1e-4, text); // it is drawn
    else assert.ok(got.wrong <= 3, text); // rays along an edge
  }
}, { releases: SOME });

inBrowser('a stream has the shadows of the whole file when its pages are there', async (page) => {
  for (const [scene, light] of [['city', 'sun'], ['room', 'lamp']]) {
    const got = await run(page, PAGE, 'streamed', { ...files(scene), light }), text = `${scene}: ${JSON.stringify(got)}`;
    assert.ok(got.before > 0.05 && got.after === 0 && got.missing === 0 && got.appeared > 0, text);
  }
});
