// bake(), in Node and in a browser, beside the native command.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, noBrowser, run, serve } from './browser.mjs';

const VXS = process.env.VXS ?? path.resolve('build/release/vxs');
const PACKAGE = process.env.VXS_PACKAGE ?? path.resolve('build/web/vxs');
const { BakeError, bake } = await import(pathToFileURL(path.join(PACKAGE, 'baker/bake.mjs')));

const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-bake-'));
const at = (name) => path.join(folder, name);
const vxs = (...args) => spawnSync(VXS, args, { cwd: folder, encoding: 'utf8' });
vxs('scene', 'city', '--triangles', '5000', '-o', 'city.glb');
vxs('bake', 'city.glb', '-o', 'city.vxs', '--resolution', '1024', '--quiet');
const glb = fs.readFileSync(at('city.glb'));
const expected = fs.readFileSync(at('city.vxs'));
const LONG = { resolution: 131072, coding: 'dag' };
after(() => fs.rmSync(folder, { recursive: true }));

test('Node: the bytes of the command, its report and its progress', async () => {
  const progress = [];
  const result = await bake(glb, { resolution: 1024, light: ['sun'] }, { onProgress: (p) => progress.push(p) });
  const plain = await bake(glb, { resolution: 1024 });
  assert.ok(expected.equals(plain.vxs));
  assert.equal(result.report.lights.length, 1);
  assert.equal(result.messages, '');
  assert.match(result.summary, /^scene .*\nlight .*\nfile /);
  assert.ok(progress.length && progress.every((p) => typeof p.doing === 'string' && (p.share === undefined || (p.share >= 0 && p.share <= 1))));
  assert.deepEqual(glb, fs.readFileSync(at('city.glb')));
});

test('Node: many at once do not disturb each other', async () => {
  const sizes = [256, 1024, 512, 1024];
  const results = await Promise.all(sizes.map((resolution) => bake(glb, { resolution })));
  for (const [n, { vxs: bytes }] of results.entries()) if (sizes[n] === 1024) assert.ok(expected.equals(bytes));
});

test('Node: threads have the same bytes, and end with the bake', async () => {
  const tasks = () => (fs.existsSync('/proc/self/task') ? fs.readdirSync('/proc/self/task').length : 0);
  await bake(glb, { resolution: 64 });
  const before = tasks();
  const results = await Promise.all([2, 4, 9].map((threads) => bake(glb, { resolution: 1024, threads })));
  for (const { vxs: bytes } of results) assert.ok(expected.equals(bytes));
  const start = performance.now();
  await assert.rejects(bake(glb, { ...LONG, threads: 3 }, { signal: AbortSignal.timeout(500) }), { name: 'TimeoutError' });
  assert.ok(performance.now() - start < 5000);
  await assert.rejects(bake(glb, { threads: 0 }), /^BakeError: --threads 0: expected/);
  for (let n = 0; n < 100 && tasks() > before; n++) await new Promise((resolve) => setTimeout(resolve, 50));
  assert.ok(tasks() <= before);
});

test('Node: WebAssembly that is given decides whether there are threads', async () => {
  for (const name of ['vxs', 'vxs-threads'])
    for (const threads of [1, 3]) {
      const { vxs: bytes } = await bake(glb, { resolution: 1024, threads }, { wasm: fs.readFileSync(path.join(PACKAGE, `baker/${name}.wasm`)) });
      assert.ok(expected.equals(bytes), `${name} ${threads}`);
    }
});

test('Node: errors are those of the command, with its exit status', async () => {
  const cases = [
    [glb, { resolution: 1000 }, ['--resolution', '1000']],
    [glb, { reslution: 512 }, ['--reslution', '512']],
    [glb, { light: 'moon' }, ['--light', 'moon']],
    [glb, { memory: '1M' }, ['--memory', '1M']],
    [Buffer.from('no scene'), {}, []],
  ];
  for (const [scene, options, args] of cases) {
    fs.writeFileSync(at('scene.glb'), scene);
    const native = vxs('bake', 'scene.glb', '-o', 'scene.vxs', '--json', 'report.json', ...args);
    await assert.rejects(bake(scene, options), (error) => {
      assert.ok(error instanceof BakeError);
      assert.equal(error.status, native.status);
      if (!options.memory) assert.equal(`vxs: error: ${error.message}\n`, native.stderr.split('\n').at(-2) + '\n');
      return true;
    });
  }
});

test('Node: warnings are messages; strict makes them errors', async () => {
  const many = { sun: ['a=0,-1,0', 'A=0.1,-1,0'], resolution: 64 };
  const result = await bake(glb, many);
  assert.match(result.messages, /^vxs: warning: .* differ in case only/);
  assert.equal(result.report.warnings.length, result.messages.trimEnd().split('\n').length);
  await assert.rejects(bake(glb, { ...many, strict: true }), BakeError);
});

test('Node: files that the scene names', async () => {
  const { gltf, bin } = split(glb);
  const result = await bake(Buffer.from(JSON.stringify(gltf)), { resolution: 1024 }, { files: { 'data/city.bin': bin } });
  fs.mkdirSync(at('data'));
  fs.writeFileSync(at('scene.glb'), JSON.stringify(gltf)); // its name is in the file
  fs.writeFileSync(at('data/city.bin'), bin);
  vxs('bake', 'scene.glb', '-o', 'gltf.vxs', '--resolution', '1024', '--quiet');
  assert.ok(fs.readFileSync(at('gltf.vxs')).equals(result.vxs));
  await assert.rejects(bake(Buffer.from(JSON.stringify(gltf))), /cannot read buffer 0, 'data\/city.bin': No such file or directory/);
});

/** A .glb as a .gltf with a file. */
function split(bytes) {
  const size = bytes.readUInt32LE(12);
  const gltf = JSON.parse(bytes.subarray(20, 20 + size).toString());
  gltf.buffers[0].uri = 'data/city.bin';
  return { gltf, bin: bytes.subarray(28 + size) };
}

test('Node: an abort ends a bake at once', async () => {
  const start = performance.now();
  await assert.rejects(bake(glb, LONG, { signal: AbortSignal.timeout(300) }), { name: 'TimeoutError' });
  assert.ok(performance.now() - start < 3000);
  await assert.rejects(bake(glb, {}, { signal: AbortSignal.abort(new Error('no')) }), /^Error: no$/);
});

test('browser', { skip: noBrowser, timeout: 120_000 }, async (t) => {
  let browser, server, page, isolated, isolatedPage;
  before(async () => {
    server = await serve(folder);
    isolated = await serve(folder, { 'cross-origin-opener-policy': 'same-origin', 'cross-origin-embedder-policy': 'require-corp' });
    browser = await launch();
    page = await openPage(server);
    isolatedPage = await openPage(isolated);
  });
  after(async () => {
    await browser?.close();
    await server?.close();
    await isolated?.close();
  });
  /** As openPage of browser.mjs, but requests are only watched: where they are intercepted, imports of workers may wait for ever. */
  async function openPage(server) {
    const opened = await browser.newPage();
    opened.faults = [];
    opened.on('console', (message) => ['error', 'warn', 'warning'].includes(message.type()) && opened.faults.push(message.text()));
    opened.on('pageerror', (error) => opened.faults.push(error.message));
    opened.on('request', (request) => request.url().startsWith(server.url) || request.url().startsWith('data:') || opened.faults.push(request.url()));
    await opened.goto(`${server.url}/page?three=three`);
    return opened;
  }
  const call = (name, argument, on = page) => run(on, '/tests/bake_page.mjs', name, argument);

  await t.test('the bytes of the command, its report and its progress', async () => {
    const result = await call('bakeScene', { url: '/files/city.glb', options: { resolution: 1024 } });
    assert.ok(expected.equals(Buffer.from(result.vxs, 'base64')));
    assert.equal(result.kept, glb.length);
    assert.equal(result.report.lights.length, 1);
    assert.ok(result.progress.length);
  });
  await t.test('a URL of the WebAssembly', async () => {
    const settings = { wasm: `${server.url}/vxs/baker/vxs.wasm` };
    const result = await call('bakeScene', { url: '/files/city.glb', options: { resolution: 1024 }, settings });
    assert.ok(expected.equals(Buffer.from(result.vxs, 'base64')));
  });
  await t.test('errors', async () => {
    assert.deepEqual(await call('failure', { url: '/files/city.glb', options: { resolution: 1000 } }),
      { isBakeError: true, name: 'BakeError', message: '--resolution 1000: expected a power of two from 8 to 262144', status: 2 });
    assert.equal((await call('failure', { options: {} })).status, 3);
  });
  await t.test('an abort ends a bake at once, and the page goes on meanwhile', async () => {
    const { name, ticks, ms } = await call('aborted', { url: '/files/city.glb', options: LONG });
    assert.equal(name, 'AbortError');
    assert.ok(ticks > 5 && ms < 5000, `${ticks} ticks in ${ms} ms`);
  });
  await t.test('threads where the page is isolated, one thread elsewhere', async () => {
    const bakeIt = { url: '/files/city.glb', options: { resolution: 1024, threads: 4 } };
    for (const [on, workers, name] of [[isolatedPage, 4, 'vxs-threads'], [page, 1, 'vxs']]) {
      const result = await call('bakeScene', bakeIt, on);
      assert.ok(expected.equals(Buffer.from(result.vxs, 'base64')));
      assert.equal(result.workers, workers);
      assert.ok(result.progress.length);
      assert.deepEqual(result.modules.slice(-1), [`${name}.wasm`]);
    }
    const { name, ticks, ms } = await call('aborted', { url: '/files/city.glb', options: { ...LONG, threads: 3 } }, isolatedPage);
    assert.equal(name, 'AbortError');
    assert.ok(ticks > 5 && ms < 5000, `${ticks} ticks in ${ms} ms`);
    assert.equal((await call('failure', { ...bakeIt, options: { threads: 2, memory: '1M' } }, isolatedPage)).status, 6);
    const given = { ...bakeIt, settings: { wasm: `${server.url}/vxs/baker/vxs-threads.wasm` } };
    assert.deepEqual(await call('failure', given),
      { isBakeError: true, name: 'BakeError', message: 'WebAssembly with threads needs a page that is cross-origin isolated', status: 3 });
    assert.deepEqual(isolatedPage.faults, []);
  });
  await t.test('nothing is reported as a fault', () => assert.deepEqual(page.faults, []));
});
