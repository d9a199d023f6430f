// The page of vxs view in Chromium, opened from a file: what it draws against `vxs render`, what it says against `vxs query`.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import zlib from 'node:zlib';
import { launch, noBrowser } from './browser.mjs';

const VXS = process.env.VXS ?? new URL('../../build/release/vxs', import.meta.url).pathname;
const PACKAGE = process.env.VXS_PACKAGE ?? new URL('../../build/web/vxs', import.meta.url).pathname,
  TEMPLATE = path.join(PACKAGE, '../view.html');
const skip =
  noBrowser ||
  (!fs.existsSync(VXS) && `no command at ${VXS}: make`) ||
  (!fs.existsSync(TEMPLATE) && `no ${TEMPLATE}: make web`);
const SIZE = [320, 240],
  WINDOW = { width: 900, height: 240 }; // the panel takes the rest of the window
const EYE = [50, 90, -60],
  TARGET = [0, 10, 0],
  FOV = 50,
  FILTER = 5;
let folder, browser;
const vxs = (args, input) =>
  execFileSync(VXS, args, { cwd: folder, input, stdio: ['pipe', 'pipe', 'pipe'] }).toString();
const view = (...args) => vxs(['view', ...args, '--page', TEMPLATE]);

before(async () => {
  if (skip) return;
  folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-view-'));
  vxs(['scene', 'city', '--triangles', '3000', '--blocks', '2', '-o', 'city.glb']);
  vxs(['bake', 'city.glb', '-o', 'city.vxs', '--resolution', '1024']);
  vxs([
    'render',
    'city.glb',
    'city.vxs',
    '-o',
    'out.png',
    '--width',
    `${SIZE[0]}`,
    '--height',
    `${SIZE[1]}`,
    '--samples',
    '1',
    `--eye=${EYE}`,
    `--target=${TARGET}`,
    '--fov',
    `${FOV}`,
    '--filter',
    `${FILTER}`,
    '--passes',
    'passes',
  ]);
  vxs(['scene', 'room', '--triangles', '3000', '-o', 'room.glb']);
  vxs(['bake', 'room.glb', '-o', 'room.vxs', '--resolution', '256']);
  view('city.glb', 'city.vxs', '-o', 'city.html');
  browser = await launch();
});

after(async () => {
  await browser?.close();
  if (folder) fs.rmSync(folder, { recursive: true });
});

/** A test in a page opened from disk. Errors and warnings of the console, and any request beside the page itself, fail it. */
function inPage(name, act, { file = () => path.join(folder, 'city.html'), allow = null } = {}) {
  test(name, { skip }, async () => {
    const page = await browser.newPage(),
      faults = [],
      fault = (text) => (allow?.test(text) ? 0 : faults.push(text));
    const url = pathToFileURL(file()).href;
    page.on(
      'console',
      (message) =>
        ['error', 'warn', 'warning'].includes(message.type()) &&
        fault(`${message.type()}: ${message.text()}`),
    );
    page.on('pageerror', (error) => fault(`page: ${error.stack ?? error.message}`));
    page.on('requestfailed', (request) =>
      fault(`failed: ${request.url().slice(0, 200)} ${request.failure()?.errorText}`),
    );
    page.on(
      'request',
      (request) =>
        request.url() === url || /^(data|blob):/.test(request.url()) || fault(`request: ${request.url()}`),
    );
    await page.setViewport(WINDOW);
    try {
      await page.goto(url);
      await page.evaluate(async () => {
        await globalThis.vxsView.ready;
        document.getElementById('panel').style.width = `${innerWidth - 320}px`;
        await new Promise((resolve) => {
          requestAnimationFrame(() => requestAnimationFrame(resolve));
        }); // it has its size
      });
      await act(page);
      assert.deepEqual(faults, []);
    } finally {
      await page.close();
    }
  });
}

/** The camera of the renderings, at once. */
const aim = (page) =>
  page.evaluate(
    (eye, target, fov) => {
      const { cameras, stage } = globalThis.vxsView,
        Vector3 = stage.camera.position.constructor;
      stage.camera.position.set(...eye);
      stage.camera.fov = fov;
      cameras.orbit.enableDamping = false;
      cameras.look(new Vector3(...target));
      stage.camera.updateMatrixWorld();
    },
    EYE,
    TARGET,
    FOV,
  );

/** Grey of a PNG of 8-bit RGB, 0 to 1; NaN where it is coloured. */
function grey(file) {
  const bytes = fs.readFileSync(file),
    data = [];
  let width, height;
  for (let at = 8; at < bytes.length; at += 12 + bytes.readUInt32BE(at)) {
    const type = bytes.toString('latin1', at + 4, at + 8),
      body = bytes.subarray(at + 8, at + 8 + bytes.readUInt32BE(at));
    if (type === 'IHDR') [width, height] = [body.readUInt32BE(0), body.readUInt32BE(4)];
    if (type === 'IDAT') data.push(body);
  }
  const raw = zlib.inflateSync(Buffer.concat(data)),
    stride = 3 * width,
    out = new Float32Array(width * height);
  let above = new Uint8Array(stride);
  for (let y = 0; y < height; y++) {
    const kind = raw[y * (stride + 1)],
      row = Uint8Array.from(raw.subarray(y * (stride + 1) + 1, (y + 1) * (stride + 1)));
    for (let x = 0; x < stride; x++) {
      const a = x >= 3 ? row[x - 3] : 0,
        b = above[x],
        c = x >= 3 ? above[x - 3] : 0,
        p = a + b - c;
      const paeth =
        Math.abs(p - a) <= Math.min(Math.abs(p - b), Math.abs(p - c))
          ? a
          : Math.abs(p - b) <= Math.abs(p - c)
            ? b
            : c;
      row[x] += [0, a, b, (a + b) >> 1, paeth][kind];
    }
    for (let x = 0; x < width; x++) {
      const [r, g, blue] = row.subarray(3 * x, 3 * x + 3);
      out[width * y + x] = r === g && g === blue ? r / 255 : NaN;
    }
    above = row;
  }
  return out;
}

inPage('shadows are those of vxs render', async (page) => {
  await aim(page);
  const lit = await page.evaluate(([width, height]) => {
    const { stage, picker } = globalThis.vxsView,
      { renderer, scene, camera } = stage,
      size = renderer.getDrawingBufferSize(new camera.position.constructor());
    const draw = () => {
      const target = new picker.target.constructor(width, height, { type: 1015 /* FloatType */ }),
        out = new Float32Array(4 * width * height);
      stage.backdrop.shine([scene], 0);
      renderer.setRenderTarget(target);
      renderer.setClearColor(0, 0);
      renderer.clear();
      renderer.render(scene, camera);
      renderer.readRenderTargetPixels(target, 0, 0, width, height, out);
      renderer.setRenderTarget(null);
      target.dispose();
      return out;
    };
    const shaded = draw();
    scene.traverse((object) => {
      object.receiveShadow = false;
    });
    const bare = draw(),
      lit = [];
    for (let y = height - 1; y >= 0; y--)
      for (let x = 0; x < width; x++) {
        const at = 4 * (width * y + x) + 1;
        lit.push(bare[at] > 1e-4 ? shaded[at] / bare[at] : -1);
      }
    return { lit, size: [size.x, size.y] };
  }, SIZE);
  assert.deepEqual(lit.size, SIZE);
  const truth = grey(path.join(folder, 'passes/lit-0-sun.png'));
  let pixels = 0,
    sum = 0,
    dark = 0,
    wrong = 0;
  lit.lit.forEach((value, n) => {
    if (value < 0 || Number.isNaN(truth[n])) return;
    const apart = Math.abs(value - truth[n]);
    pixels++;
    sum += apart;
    dark += truth[n] < 0.5;
    wrong += apart > 0.5;
  });
  assert.ok(pixels > 10000 && dark > 1000 && dark < pixels / 2, `${pixels} pixels, ${dark} in shadow`);
  assert.ok(
    sum / pixels < 0.004 && wrong < 0.002 * pixels,
    `mean ${sum / pixels}, ${wrong} of ${pixels} wrong`,
  );
});

inPage('what is told of texels is what vxs query answers', async (page) => {
  await aim(page);
  await page.evaluate(() => {
    globalThis.vxsView.stage.render = () => {}; // the picture is not looked at
  });
  const told = [];
  for (let n = 0; n < 16; n++) {
    const [x, y] = [70 + 60 * (n % 4), 60 + 41 * Math.floor(n / 4)];
    await page.mouse.move(x, y);
    await page.waitForFunction(() => !globalThis.vxsView.pointerMoved);
    const each = await page.evaluate(() => ({
      told: globalThis.vxsView.card.told,
      at:
        globalThis.vxsView.card.told &&
        (({ camera }, { point }) => {
          const { x: u, y: v } = new camera.position.constructor(...point).project(camera),
            { width, height } = document.getElementById('canvas').getBoundingClientRect();
          return [(0.5 + 0.5 * u) * width, (0.5 - 0.5 * v) * height];
        })(globalThis.vxsView.stage, globalThis.vxsView.card.told),
      text: document.getElementById('texel').textContent,
      hidden: document.getElementById('texel').hidden,
    }));
    assert.equal(each.hidden, !each.told);
    if (!each.told) continue;
    assert.ok(
      Math.abs(each.at[0] - x - 0.5) < 0.1 && Math.abs(each.at[1] - y - 0.5) < 0.1,
      `the surface at ${x}, ${y} is drawn at ${each.at}`,
    );
    told.push(each);
  }
  const lines = told.map(({ told: { point, normal } }) => [...point, ...normal].join(' ')).join('\n');
  const answers = vxs(['query', 'city.vxs', '--filter', `${FILTER}`], lines)
    .trim()
    .split('\n');
  const states = {};
  told.forEach(({ told: { lit, state, texel, depth, light, firstShadow }, text }, n) => {
    states[state] = (states[state] ?? 0) + 1;
    assert.equal(
      answers[n] === 'out' ? -1 : Number(answers[n]),
      Number(lit.toPrecision(6)),
      `point ${n}: ${text}`,
    );
    assert.ok(text.includes(`${light}: texel ${texel.join(', ')}, depth ${depth}`), text);
    if (state === 'lit') assert.equal(lit, 1);
    if (state === 'shadow')
      assert.ok(lit === 0 && firstShadow <= depth && text.includes(`begins at voxel ${firstShadow}`), text);
    if (state === 'away') assert.match(text, /faces away/);
  });
  assert.ok(told.length >= 10 && states.lit && states.shadow && states.away, JSON.stringify(states));
  const depths = await page.evaluate(
    (points) =>
      points.map(({ told: { map, texel } }) =>
        globalThis.vxsView.asset.light('sun').firstShadow(map, ...texel),
      ),
    told,
  );
  assert.deepEqual(
    told.map((each) => each.told.firstShadow),
    depths,
  );
});

/** Draw the picture anew, and keep its pixels in the page. Returns their name. */
const pixels = (page) =>
  page.evaluate(() => {
    const { stage } = globalThis.vxsView,
      gl = stage.renderer.getContext(),
      { drawingBufferWidth: w, drawingBufferHeight: h } = gl,
      out = new Uint8Array(4 * w * h);
    stage.render();
    gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, out);
    return (globalThis.pictures ??= []).push({ w, out }) - 1;
  });
/** Share of pixels that differ clearly between two pictures, of the columns [from, until). */
const changed = (page, ...given) =>
  page.evaluate(
    (a, b, from = 0, until = Infinity) => {
      const [{ w, out: one }, { out: other }] = [globalThis.pictures[a], globalThis.pictures[b]];
      let count = 0,
        all = 0;
      for (let n = 0; n < one.length / 4; n++) {
        if (n % w < from || n % w >= until) continue;
        all++;
        if ([0, 1, 2].some((c) => Math.abs(one[4 * n + c] - other[4 * n + c]) > 12)) count++;
      }
      return count / all;
    },
    ...given,
  );
const click = (page, text) =>
  page.evaluate((label) => {
    const found = [...document.querySelectorAll('#panel label, #panel button, #panel summary')].filter(
      (each) => each.textContent.trim().startsWith(label),
    );
    if (found.length !== 1) throw new Error(`${found.length} controls '${label}'`);
    found[0].click();
  }, text);
const slide = (page, name, value) =>
  page.evaluate(
    (label, to) => {
      const input = document.querySelector(`#panel input[aria-label="${label}"]`);
      input.value = to;
      input.dispatchEvent(new Event('input'));
    },
    name,
    value,
  );

inPage('each control changes the picture, and only as it should', async (page) => {
  await aim(page);
  await page.evaluate(() => {
    globalThis.vxsView.stage.measure(); // as switching fog does
    globalThis.vxsView.redraw = () => {}; // pixels() draws
  });
  const first = await pixels(page);
  assert.equal(await changed(page, first, await pixels(page)), 0);

  await click(page, 'sun');
  const off = await pixels(page);
  assert.ok((await changed(page, first, off)) > 0.1, 'the sun off');
  await click(page, 'sun');
  assert.equal(await changed(page, first, await pixels(page)), 0, 'the sun on');

  await slide(page, 'Filter', 17);
  const wide = await pixels(page);
  assert.ok((await changed(page, first, wide)) > 0.005, 'a filter of 17 x 17');
  await click(page, 'Smooth');
  await slide(page, 'Filter', 6);
  assert.deepEqual(await page.evaluate(() => globalThis.vxsView.stage.filter), { smooth: 6 });
  assert.ok((await changed(page, wide, await pixels(page))) > 0.005, 'a smooth filter');
  await click(page, 'Box');
  await slide(page, 'Filter', 5);
  assert.equal(await changed(page, first, await pixels(page)), 0, 'back to 5 x 5');

  await slide(page, 'Exposure', 2);
  assert.ok((await changed(page, first, await pixels(page))) > 0.3, 'two stops');
  await slide(page, 'Exposure', 0);
  await slide(page, 'Sky light', 0);
  assert.ok((await changed(page, first, await pixels(page))) > 0.05, 'no light from the sky');
  await slide(page, 'Sky light', 0.5);

  await page.evaluate(() =>
    [...document.querySelectorAll('#panel input[type="checkbox"]')]
      .find((input) => input.parentElement.textContent === 'Fog')
      .click(),
  );
  const thin = await pixels(page);
  assert.ok((await changed(page, first, thin)) > 0.5, 'fog');
  await slide(
    page,
    'Density',
    await page.evaluate(() => Math.log10(globalThis.vxsView.stage.fog.extinction) + 0.7),
  );
  const dense = await changed(page, thin, await pixels(page));
  assert.ok(dense > 0.05, `dense fog: ${dense}`);
  await page.evaluate(() =>
    [...document.querySelectorAll('#panel input[type="checkbox"]')]
      .find((input) => input.parentElement.textContent === 'Fog')
      .click(),
  );
  assert.ok((await changed(page, first, await pixels(page))) < 0.01, 'no fog');

  await click(page, 'None');
  const none = await pixels(page),
    half = SIZE[0] / 2;
  assert.ok((await changed(page, first, none, 0, half - 1)) < 0.01, 'the baked half stays');
  assert.ok((await changed(page, first, none, half + 1)) > 0.02, 'the other half has no shadows');
  await click(page, 'Live 2048');
  const live = await pixels(page);
  assert.ok(
    (await changed(page, none, live, half + 1)) > 0.02 && (await changed(page, first, live, half + 1)) < 0.05,
    'a live map is near the baked one',
  );
  await page.focus('#split');
  for (let n = 0; n < 5; n++) await page.keyboard.press('ArrowRight');
  assert.equal(await page.$eval('#split', (element) => element.getAttribute('aria-valuenow')), '60');
  await page.keyboard.press('Home');
  assert.ok((await changed(page, live, await pixels(page), 1, half)) > 0, 'all of it is the live map');
  await click(page, 'Off');
  assert.ok((await changed(page, first, await pixels(page))) < 0.01, 'as at first');
});

inPage('a lost context comes back', async (page) => {
  await aim(page);
  const before = await pixels(page);
  await page.evaluate(async () => {
    const canvas = document.getElementById('canvas');
    const lost = canvas.getContext('webgl2').getExtension('WEBGL_lose_context');
    const event = (name) => new Promise((resolve) => canvas.addEventListener(name, resolve, { once: true }));
    const gone = event('webglcontextlost');
    lost.loseContext();
    await gone;
    const back = event('webglcontextrestored');
    setTimeout(() => lost.restoreContext());
    await back;
  });
  assert.ok((await changed(page, before, await pixels(page))) < 0.01);
});

inPage('numbers and warnings', async (page) => {
  const text = await page.$eval('#panel', (panel) => panel.innerText);
  const { meshes, triangles } = await page.evaluate(() => {
    const found = { meshes: 0, triangles: 0 };
    globalThis.vxsView.root.traverse((o) => {
      if (o.isMesh)
        Object.assign(found, {
          meshes: found.meshes + 1,
          triangles: found.triangles + o.geometry.index.count / 3,
        });
    });
    return found;
  });
  const number = (name) => Number(new RegExp(`${name}\\s+([\\d,.]+)`).exec(text)[1].replaceAll(',', ''));
  assert.equal(number('Draws saved'), meshes);
  assert.equal(number('Triangles saved'), triangles);
  assert.equal(number('16-bit depth maps'), 2);
  assert.equal(
    number('Baked shadows'),
    Number((fs.statSync(path.join(folder, 'city.vxs')).size / 1024).toFixed(1)),
  );
  assert.match(text, /Warnings \(0\)/);
  // what live maps draw, counted by three.js itself
  const live = await page.evaluate(() => {
    const view = globalThis.vxsView,
      { stage } = view,
      { info } = stage.renderer;
    stage.split = 0;
    view.compare('live');
    stage.render();
    const all = info.render.calls;
    view.compare('none');
    stage.render();
    return all - info.render.calls;
  });
  assert.equal(live, meshes);
});

inPage('the page is used with the keyboard, and fits its window', async (page) => {
  await page.focus('#canvas');
  await page.keyboard.press('p');
  await page.waitForFunction(
    () => document.getElementById('panel').hidden && document.getElementById('canvas').width === 900,
  );
  await page.keyboard.press('p');
  await page.keyboard.press('c');
  assert.equal(await page.evaluate(() => globalThis.vxsView.stage.compare), 'live');
  const before = await page.evaluate(() => globalThis.vxsView.stage.camera.position.toArray());
  await page.keyboard.press('f');
  await page.keyboard.down('w');
  await page.waitForFunction(
    (from) =>
      globalThis.vxsView.stage.camera.position.toArray().some((value, n) => Math.abs(value - from[n]) > 0.1),
    {},
    before,
  );
  await page.keyboard.up('w');
  await page.keyboard.press('Escape');
  await page.waitForFunction(() => !globalThis.vxsView.cameras.walking);
  await page.evaluate(() => {
    document.getElementById('panel').style.width = '';
  });
  await page.setViewport({ width: 390, height: 700 });
  await page.waitForFunction(() => document.getElementById('canvas').getBoundingClientRect().width === 390);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth));
});

/** Drop files on the page as a person does. files: { name: bytes } */
const drop = (page, files) =>
  page.evaluate(
    async (given) => {
      const transfer = new DataTransfer(),
        view = globalThis.vxsView;
      for (const [name, text] of Object.entries(given))
        transfer.items.add(new File([Uint8Array.from(atob(text), (c) => c.charCodeAt(0))], name));
      const taken = new Promise((resolve) => {
        const { attempt } = view;
        view.attempt = function told(work) {
          view.attempt = attempt;
          const done = attempt.call(view, work);
          done.then(resolve);
          return done;
        };
      });
      dispatchEvent(new DragEvent('drop', { dataTransfer: transfer, bubbles: true, cancelable: true }));
      await taken;
      return {
        title: document.title,
        message: document.getElementById('message').open
          ? document.getElementById('message').querySelector('p').textContent
          : '',
        lights: view.stage.lights.map(({ baked }) => baked?.name ?? null),
      };
    },
    Object.fromEntries(Object.entries(files).map(([name, bytes]) => [name, bytes.toString('base64')])),
  );
const read = (name) => fs.readFileSync(path.join(folder, name));

/** A .glb file that holds a .vxs file, by the extension VXS_baked_shadows. */
function withShadows(glb, asset) {
  const size = glb.readUInt32LE(12),
    json = JSON.parse(glb.toString('utf8', 20, 20 + size)),
    bin = glb.subarray(28 + size);
  json.bufferViews.push({ buffer: 0, byteOffset: bin.length, byteLength: asset.length });
  json.buffers[0].byteLength = bin.length + asset.length;
  json.extensions.VXS_baked_shadows = { bufferView: json.bufferViews.length - 1 };
  json.extensionsUsed.push('VXS_baked_shadows');
  const text = Buffer.from(JSON.stringify(json)),
    chunk = (type, data, fill) => {
      const padded = Buffer.concat([data, Buffer.alloc(-data.length & 3, fill)]);
      return Buffer.concat([Buffer.from(Uint32Array.of(padded.length, type).buffer), padded]);
    };
  const chunks = [chunk(0x4e4f534a, text, ' '), chunk(0x004e4942, Buffer.concat([bin, asset]), 0)];
  const all = Buffer.concat(chunks);
  return Buffer.concat([Buffer.from(Uint32Array.of(0x46546c67, 2, 12 + all.length).buffer), all]);
}

inPage('files are dropped onto the page', async (page) => {
  const room = await drop(page, { 'room.glb': read('room.glb'), 'room.vxs': read('room.vxs') });
  assert.deepEqual(
    [room.title, room.message, room.lights.sort()],
    ['room.glb - vxs view', '', ['corner', 'lamp']],
  );
  assert.deepEqual((await drop(page, { 'city.glb': read('city.glb') })).lights, [null]);
  assert.match(await page.$eval('#panel', (panel) => panel.innerText), /There is no \.vxs file/);
  assert.deepEqual((await drop(page, { 'city.vxs': read('city.vxs') })).lights, ['sun']);
  const inside = await drop(page, { 'one.glb': withShadows(read('city.glb'), read('city.vxs')) });
  assert.deepEqual([inside.title, inside.message, inside.lights], ['one.glb - vxs view', '', ['sun']]);
});

inPage('a damaged file is a message, and what was shown stays', async (page) => {
  const damaged = Buffer.from(read('city.vxs'));
  damaged[damaged.length >> 1] ^= 1;
  const told = await drop(page, { 'city.vxs': damaged });
  assert.match(told.message, /^city\.vxs cannot be opened: .*\(finding \d+\)\.$/);
  assert.deepEqual([told.title, told.lights], ['city.glb - vxs view', ['sun']]);
  for (const [files, says] of [
    [{ 'a.txt': Buffer.from('x') }, /Drop a scene/],
    [{ 'a.glb': Buffer.from('x') }, /a\.glb is not a glTF 2\.0 scene/],
    [
      { 'a.gltf': Buffer.from('{"asset":{"version":"2.0"},"buffers":[{"byteLength":4,"uri":"a%20b.bin"}]}') },
      /a\.gltf needs the file a%20b\.bin/,
    ],
    [{ 'a.glb': read('city.glb').subarray(0, 1000) }, /a\.glb/],
    [{ 'a.vxs': read('city.vxs'), 'b.vxs': read('city.vxs') }, /one \.vxs file at a time/],
  ]) {
    await page.evaluate(() => document.getElementById('message').close());
    assert.match((await drop(page, files)).message, says);
  }
});

inPage(
  'the template without a level takes files',
  async (page) => {
    assert.equal(await page.$eval('#drop', (element) => element.hidden), false);
    assert.match(
      (await drop(page, { 'city.vxs': read('city.vxs') })).message,
      /Drop the scene of city\.vxs as well/,
    );
    await page.evaluate(() => document.getElementById('message').close());
    assert.deepEqual(
      (await drop(page, { 'city.glb': read('city.glb'), 'city.vxs': read('city.vxs') })).lights,
      ['sun'],
    );
    assert.equal(await page.$eval('#drop', (element) => element.hidden), true);
  },
  { file: () => TEMPLATE },
);

inPage(
  'a page that is cut short says so',
  async (page) => {
    assert.match(await page.$eval('#message', (element) => element.textContent), /This page is not complete/);
  },
  {
    file() {
      const text = fs.readFileSync(path.join(folder, 'city.html'), 'utf8');
      fs.writeFileSync(
        path.join(folder, 'cut.html'),
        text.replace(/(data-vxs="0">)[A-Za-z0-9+/]{400}/, '$1'),
      );
      return path.join(folder, 'cut.html');
    },
  },
);

inPage(
  'a scene of several files, and suns of the command line',
  async (page) => {
    const map = await page.evaluate(() => {
      let image = null;
      globalThis.vxsView.root.traverse((object) => {
        image ??= object.material?.map?.image;
      });
      return [image.width, image.height];
    });
    assert.deepEqual(map, [2, 2]);
    assert.deepEqual(
      await page.evaluate(() =>
        globalThis.vxsView.stage.lights.map(({ baked, light }) => [baked?.name, light.isDirectionalLight]),
      ),
      [['noon', true]],
    );
    assert.match(await page.$eval('#panel', (panel) => panel.innerText), /noon: in the \.vxs file alone/);
    assert.match(await page.$eval('#panel', (panel) => panel.innerText), /gone\.png/);
  },
  {
    file() {
      const positions = Float32Array.of(-1, 0, -1, 1, 0, -1, 1, 0, 1, -1, 0, 1),
        texcoords = Float32Array.of(0, 0, 1, 0, 1, 1, 0, 1),
        indices = Uint32Array.of(0, 2, 1, 0, 3, 2);
      fs.writeFileSync(
        path.join(folder, 'a b.bin'),
        Buffer.concat([positions, texcoords, indices].map((each) => Buffer.from(each.buffer))),
      );
      // 2 x 2 pixels, grey
      const chunk = (type, body) => {
        const data = Buffer.concat([Buffer.from(type), body]),
          out = Buffer.alloc(12 + body.length),
          table = Int32Array.from({ length: 256 }, (_, n) => {
            for (let k = 0; k < 8; k++) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1;
            return n;
          });
        out.writeUInt32BE(body.length);
        data.copy(out, 4);
        out.writeInt32BE(
          ~data.reduce((crc, byte) => table[(crc ^ byte) & 255] ^ (crc >>> 8), -1),
          8 + body.length,
        );
        return out;
      };
      fs.writeFileSync(
        path.join(folder, 'w%C3%A4nd.png'),
        Buffer.concat([
          Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'),
          chunk('IHDR', Buffer.from([0, 0, 0, 2, 0, 0, 0, 2, 8, 0, 0, 0, 0])),
          chunk('IDAT', zlib.deflateSync(Buffer.from([0, 90, 180, 0, 180, 90]))),
          chunk('IEND', Buffer.alloc(0)),
        ]),
      );
      fs.writeFileSync(
        path.join(folder, 'apart.gltf'),
        JSON.stringify({
          asset: { version: '2.0' },
          scene: 0,
          scenes: [{ nodes: [0] }],
          nodes: [{ mesh: 0 }],
          meshes: [{ primitives: [{ attributes: { POSITION: 0, TEXCOORD_0: 1 }, indices: 2, material: 0 }] }],
          materials: [
            { pbrMetallicRoughness: { baseColorTexture: { index: 0 } }, emissiveTexture: { index: 1 } },
          ],
          textures: [{ source: 0 }, { source: 1 }],
          images: [{ uri: 'w%25C3%25A4nd.png' }, { uri: 'gone.png' }],
          buffers: [{ byteLength: 104, uri: 'a%20b.bin' }],
          bufferViews: [
            { buffer: 0, byteLength: 48 },
            { buffer: 0, byteOffset: 48, byteLength: 32 },
            { buffer: 0, byteOffset: 80, byteLength: 24 },
          ],
          accessors: [
            { bufferView: 0, componentType: 5126, count: 4, type: 'VEC3', min: [-1, 0, -1], max: [1, 0, 1] },
            { bufferView: 1, componentType: 5126, count: 4, type: 'VEC2' },
            { bufferView: 2, componentType: 5125, count: 6, type: 'SCALAR' },
          ],
        }),
      );
      view('apart.gltf', '--sun', 'noon=0,-1,0', '--resolution', '64', '-o', 'apart.html');
      return path.join(folder, 'apart.html');
    },
  },
);
