// The runtime as WebAssembly beside the C library: every answer bit for bit, wrong arguments, disposal, modules of all kinds.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { test } from 'node:test';
import { Worker } from 'node:worker_threads';
import zlib from 'node:zlib';

import { PACKAGE, answers, baked, pointsFor, runtime } from './native.mjs';

const { VXSError, load } = await runtime();
const vxs = await load();
const FILES = {
  city: [baked('city', 'city', ['--resolution', '4096']), 20000],
  small: [baked('small', 'pillars', ['--resolution', '512', '--points', '500']), 4000],
  fast: [baked('fast', 'pillars', ['--resolution', '1024', '--pack', 'fast']), 4000],
  dag: [baked('dag', 'pillars', ['--resolution', '256', '--coding', 'dag']), 4000],
  smoke: [baked('smoke', 'smoke', ['--resolution', '256', '--scene-smoke', 'on']), 4000],
};
const FILTERS = { 'box 1': undefined, 'box 9': 9, 'smooth 4': { smooth: 4 }, 'smooth 9': { smooth: 9 } };
const RAYS = 300, SHIFT = 3;
const ESBUILD = path.join(PACKAGE, '../node_modules/.bin/esbuild');
const open = (name) => vxs.open(fs.readFileSync(FILES[name][0]));
const bytes = (array) => Buffer.from(array.buffer, array.byteOffset, array.byteLength);

/** Every nth of six numbers, from `first` on. */
const parts = (list, first) =>
  Array.from({ length: list.length / 6 }, (_, n) => [...list.subarray(6 * n + first, 6 * n + first + 3)]);

/** Ends of intervals are the results of exp and log, which may differ in the last bits between C libraries. */
function sameRays(rays, written) {
  const want = new Float64Array(written.buffer.slice(written.byteOffset, written.byteOffset + written.length));
  assert.equal(3 * rays.length, want.length);
  rays.forEach(({ begin, end, state }, n) => {
    const near = (a, b) => a === b || Math.abs(a - b) < 1e-12 * (1 + Math.abs(b));
    assert.ok(near(begin, want[3 * n]) && near(end, want[3 * n + 1]), `${n}`);
    assert.equal(state, ['lit', 'shadow', 'outside'][want[3 * n + 2]]);
  });
}

for (const [name, [file, count]] of Object.entries(FILES)) {
  test(`${name}: all answers are those of C, bit for bit`, () => {
    const asset = open(name), list = pointsFor(asset.lights, count), expected = answers(file, list);
    const points = parts(list, 0), normals = parts(list, 3), flat = Float64Array.from(points.flat());
    const same = (what, light, got) => {
      const key = `${what} ${light}`, want = expected.get(key);
      expected.delete(key);
      assert.ok(want, key);
      assert.ok(bytes(got).equals(want), `${name}, ${key}`);
    };
    asset.lights.forEach((light, n) => {
      same('constants', n, light.constants([1, 2, 3], 7));
      same('matrix', n, light.matrix);
      same('words', n, light.words());
      for (const [what, filter] of Object.entries(FILTERS)) {
        const single = points.map((p) => light.lookup(p, { filter }));
        same(what, n, Float32Array.from([...single, ...points.map((p, k) => light.lookup(p, { filter, normal: normals[k] }))]));
        assert.deepEqual(light.lookupMany(flat, { filter }), Float32Array.from(single));
        const many = light.lookupMany(flat, { filter, normals: Float64Array.from(normals.flat()) });
        assert.deepEqual([...many], points.map((p, k) => light.lookup(p, { filter, normal: normals[k] })));
        const floats = Float32Array.from(flat);
        assert.deepEqual(light.lookupMany(floats, { filter }), light.lookupMany(Float64Array.from(floats), { filter }));
      }
      const voxels = points.map((p, k) => light.voxel(p, { filter: 9, normal: normals[k] }));
      const written = expected.get(`voxel ${n}`), at = (k) => [0, 4, 8, 12].map((b) => written.readInt32LE(16 * k + b));
      voxels.forEach((v, k) => assert.deepEqual(v && [v.map, ...v.voxel], at(k)[0] < 0 ? null : at(k), `${k}`));
      const side = light.resolution - 1;
      const first = (k) => light.firstShadow(Math.max(at(k)[0], 0), at(k)[1] & side, at(k)[2] & side);
      same('first shadow', n, Int32Array.from(points, (_, k) => first(k)));
      expected.delete(`voxel ${n}`);
      const isRay = (p) => p.every((x) => Math.abs(x) <= 1e50);
      const ray = (p, k) => light.intervals(p, normals[k], 0, k % 2 ? Infinity : 50);
      const rays = points.slice(0, RAYS).flatMap((p, k) => (isRay(p) ? ray(p, k) : []));
      sameRays(rays, expected.get(`rays ${n}`));
      expected.delete(`rays ${n}`);
      for (const which of ['centre', 'least', 'greatest']) {
        const options = { map: light.maps - 1, which, shift: SHIFT };
        same(`depths ${which}`, n, light.depthMap(options).data);
        same(`voxels ${which}`, n, light.depthMap({ ...options, voxels: true }).data);
      }
      same('smoke', n, light.smokeLookupMany(flat));
      assert.equal(light.hasSmoke, name === 'smoke');
    });
    if (asset.points) same('points', 0, asset.points.unpack([1, 2, 3]));
    assert.equal(Boolean(asset.points), name === 'small');
    assert.deepEqual([...expected.keys()], []);
    asset.dispose();
  });
}

test('depth maps: any rectangle is the same part of the whole map, also of more rows than a strip has', () => {
  const light = open('small').light('spot'), whole = light.depthMap(), side = light.resolution;
  const part = light.depthMap({ x: -3, y: side - 40, width: side + 10, height: 60 });
  for (let row = 0; row < 60; row++) {
    for (let column = 0; column < side + 10; column++) {
      const x = column - 3, y = row + side - 40, inside = x >= 0 && x < side && y < side;
      assert.equal(part.data[row * (side + 10) + column], inside ? whole.data[y * side + x] : 1);
    }
  }
  assert.deepEqual(light.depthMap({ resolution: 64 }), light.depthMap({ shift: Math.log2(side / 64) }));
  const sun = open('city').lights[0], wide = sun.resolution, { data } = sun.depthMap({ voxels: true });
  for (let n = 0; n < 5000; n++) {
    const i = 797 * n % wide, j = 1231 * n % wide;
    assert.equal(data[j * wide + i], sun.firstShadow(0, i, j));
  }
});

test('lights: what their files say', () => {
  const asset = open('small'), [sun, spot, lamp] = asset.lights;
  assert.deepEqual(asset.lights.map((l) => [l.index, l.name, l.kind, l.maps]),
    [[0, 'sun', 'directional', 1], [1, 'spot', 'spot', 1], [2, 'lamp', 'point', 6]]);
  assert.deepEqual([sun.levels, sun.resolution, sun.coding, sun.packing], [9, 512, 'blocks', 'small']);
  assert.equal(open('fast').lights[0].packing, 'fast');
  assert.equal(open('dag').lights[0].coding, 'dag');
  assert.ok(Math.abs(spot.cosOuter - Math.cos(0.6)) < 1e-6 && Math.abs(lamp.rangeMetres - 25) < 1e-6);
  assert.ok(Math.abs(Math.hypot(...sun.direction) - 1) < 1e-12);
  assert.equal(asset.light('spot'), spot);
  assert.equal(asset.light(2), lamp);
  assert.match(asset.info.generator, /^vxs /);
  assert.throws(() => asset.light('moon'), { name: 'RangeError', message: 'no light "moon"; there are: sun, spot, lamp' });
  assert.throws(() => asset.light(3), RangeError);
  assert.equal(sun.smokeLookup([0, 1, 0]), 1);
  assert.equal(sun.smokeWords(), null);
  const smoke = open('smoke').lights[0];
  assert.ok(smoke.smokeWords().length > 3);
});

test('wrong arguments: a TypeError or a RangeError that names them', () => {
  const asset = open('small'), light = asset.light('lamp'), at = [0, 1, 0];
  const wrong = [
    [() => light.lookup(), TypeError, /point/],
    [() => light.lookup([1, 2]), TypeError, /point/],
    [() => light.lookup('xyz'), TypeError, /point/],
    [() => light.lookup(at, { normal: [1] }), TypeError, /normal/],
    [() => light.lookup(at, { filter: 4 }), RangeError, /odd/],
    [() => light.lookup(at, { filter: 19 }), RangeError, /filter is 19/],
    [() => light.lookup(at, { filter: NaN }), RangeError, /filter/],
    [() => light.lookup(at, { filter: { smooth: 0 } }), RangeError, /smooth/],
    [() => light.lookup(at, { filter: {} }), RangeError, /filter/],
    [() => light.lookupMany(new Float64Array(4)), RangeError, /three/],
    [() => light.lookupMany(new Int32Array(3)), TypeError, /points/],
    [() => light.lookupMany(new Float64Array(6), { normals: new Float64Array(3) }), RangeError, /normals/],
    [() => light.lookupMany(new Float64Array(6), { out: new Float32Array(1) }), RangeError, /out/],
    [() => light.lookupMany(new Float64Array(6), { out: new Float64Array(2) }), TypeError, /out/],
    [() => light.firstShadow(6, 0, 0), RangeError, /map is 6/],
    [() => light.firstShadow(0, -1, 0), RangeError, /i is -1/],
    [() => light.firstShadow(0, 0, 512), RangeError, /j is 512/],
    [() => light.firstShadow(0, 0.5, 0), RangeError, /i is 0.5/],
    [() => light.depthMap({ map: -1 }), RangeError, /map/],
    [() => light.depthMap({ resolution: 1000 }), RangeError, /resolution/],
    [() => light.depthMap({ resolution: 300 }), RangeError, /power of two/],
    [() => light.depthMap({ shift: 10 }), RangeError, /shift/],
    [() => light.depthMap({ shift: 1, resolution: 8 }), TypeError, /exclude/],
    [() => light.depthMap({ which: 'middle' }), RangeError, /middle/],
    [() => light.depthMap({ which: 'toString' }), RangeError, /toString/],
    [() => light.depthMap({ width: 2 ** 31 }), RangeError, /width/],
    [() => light.depthMap({ x: NaN }), RangeError, /x is NaN/],
    [() => light.intervals(at, [0, NaN, 0]), RangeError, /finite/],
    [() => light.intervals(at, [0, 1, 0], 2, 1), RangeError, /tEnd/],
    [() => light.intervals(at, [0, 1, 0], '1'), RangeError, /tEnd/],
    [() => light.constants(at, -1), RangeError, /firstWord/],
    [() => light.point(6, at), RangeError, /map/],
    [() => vxs.open('level.vxs'), TypeError, /bytes/],
    [() => vxs.open(new Uint8Array(1), { memoryLimit: -1 }), RangeError, /memoryLimit/],
    [() => vxs.open(new Uint8Array(1), { memoryLimit: NaN }), RangeError, /memoryLimit/],
  ];
  for (const [call, kind, message] of wrong) assert.throws(call, (e) => e instanceof kind && message.test(e.message), String(call));
  for (const point of [[NaN, 0, 0], [0, Infinity, 0], [0, 0, -1e300]]) assert.equal(light.lookup(point), -1);
});

test('vectors: arrays, typed arrays and objects with x, y, z', () => {
  const light = open('small').lights[0], want = light.lookup([0.5, 0.1, 0.5], { filter: 9 });
  assert.equal(light.lookup({ x: 0.5, y: 0.1, z: 0.5 }, { filter: 9 }), want);
  assert.equal(light.lookup(Float64Array.of(0.5, 0.1, 0.5), { filter: { box: 9 } }), want);
  assert.equal(light.lookupMany([0.5, 0.1, 0.5], { filter: 9 })[0], want);
  const out = new Float32Array(3).fill(7);
  assert.equal(light.lookupMany([0.5, 0.1, 0.5], { filter: 9, out }), out);
  assert.deepEqual([...out], [Math.fround(want), 7, 7]);
});

test('disposal: all calls throw afterwards; the memory is used again; other files stay', () => {
  const first = open('small'), second = open('dag'), light = first.lights[0];
  first.dispose();
  first.dispose();
  assert.ok(first.disposed && !second.disposed);
  for (const call of [() => light.lookup([0, 0, 0]), () => light.lookupMany([]), () => light.words(), () => light.depthMap(),
    () => light.constants(), () => light.intervals([0, 0, 0], [0, 1, 0]), () => light.voxel([0, 0, 0]),
    () => light.firstShadow(0, 0, 0), () => light.hasSmoke, () => light.isFull([0, 0, 0]),
    () => light.point(0, [0, 0, 0]), () => first.points, () => first.info]) {
    assert.throws(call, (e) => e instanceof VXSError && e.code === 'disposed', String(call));
  }
  assert.equal(light.name, 'sun');
  assert.ok(second.lights[0].lookup([0, 1, 0]) >= -1);
});

test('1000 files are opened and disposed of in the memory of a few', async () => {
  const here = await load(), good = fs.readFileSync(FILES.small[0]), bad = Buffer.from(good);
  bad[bad.length - 1] ^= 1;
  const once = () => {
    const asset = here.open(good);
    asset.lights[2].lookupMany(new Float64Array(300), { filter: 9 });
    asset.lights[0].depthMap({ resolution: 64 });
    asset.dispose();
    assert.throws(() => here.open(bad), VXSError);
  };
  for (let n = 0; n < 5; n++) once();
  const size = here.memoryBytes;
  for (let n = 0; n < 1000; n++) once();
  assert.equal(here.memoryBytes, size);
});

test('instances do not meet: each has its memory', async () => {
  const [one, two] = [await load(), await load()], before = two.memoryBytes;
  const asset = one.open(fs.readFileSync(FILES.city[0]));
  assert.equal(two.memoryBytes, before);
  const far = two.open(fs.readFileSync(FILES.small[0]));
  assert.ok(asset.lights[0].words().length > 1000 && far.lights.length === 3);
});

test('memory that grows while a file is open moves nothing that the caller has', async () => {
  const here = await load(), asset = here.open(fs.readFileSync(FILES.small[0])), light = asset.lights[0];
  const words = light.words(), before = light.lookup([0.5, 0.1, 0.5], { filter: 9 }), size = here.memoryBytes;
  const large = fs.readFileSync(baked('large', 'city', ['--resolution', '16384']));
  here.open(large);
  assert.ok(here.memoryBytes > size);
  // an error after the memory has grown, too
  const fresh = await load(), little = fresh.memoryBytes;
  assert.throws(() => fresh.open(large, { memoryLimit: 2e6 }), { code: 'memory', finding: 211 });
  assert.ok(fresh.memoryBytes > little);
  assert.deepEqual(light.words(), words);
  assert.equal(light.lookup([0.5, 0.1, 0.5], { filter: 9 }), before);
});

test('WebAssembly from a URL, bytes, a module, a response, base64; require(); a worker', async () => {
  const wasm = fs.readFileSync(path.join(PACKAGE, 'runtime/vxs.wasm')), file = fs.readFileSync(FILES.small[0]);
  const want = open('small').lights[0].words();
  const loads = [load({ wasm }), load({ wasm: new WebAssembly.Module(wasm) }), load({ wasm: Promise.resolve(wasm) }),
    load({ wasm: new Response(wasm, { headers: { 'content-type': 'application/wasm' } }) }),
    load({ wasm: new URL(`file://${path.join(PACKAGE, 'runtime/vxs.wasm')}`) }), (await runtime('vxs-inline.mjs')).load(),
    createRequire(import.meta.url)(path.join(PACKAGE, 'runtime/vxs.cjs')).load()];
  for (const here of await Promise.all(loads)) assert.deepEqual(here.open(file).lights[0].words(), want);
  for (const url of ['file:///nowhere/vxs.wasm', 'http://127.0.0.1:1/vxs.wasm']) {
    await assert.rejects(load({ wasm: url }), (e) => e.code === 'read' && e.message.startsWith(url) && e.cause instanceof Error);
  }
  await assert.rejects(load({ wasm: new Response('', { status: 404 }) }), (e) => e.code === 'read' && /404/.test(e.message));
  const code = `const { parentPort, workerData: w } = require('node:worker_threads');
    import(w.module).then(async ({ load }) =>
      parentPort.postMessage((await load({ wasm: w.wasm })).open(w.file).lights[0].words()));`;
  const workerData = { module: path.join(PACKAGE, 'runtime/vxs.mjs'), file, wasm: new WebAssembly.Module(wasm) };
  const worker = new Worker(code, { eval: true, workerData });
  assert.deepEqual(await new Promise((resolve, reject) => worker.on('message', resolve).on('error', reject)), want);
});

test('core: the same words, constants and depth maps, and no lookups', async () => {
  const core = await (await runtime('core.mjs')).load(), file = fs.readFileSync(FILES.small[0]), asset = core.open(file);
  asset.lights.forEach((light, n) => {
    const other = open('small').lights[n];
    assert.deepEqual(light.words(), other.words());
    assert.deepEqual(light.constants([1, 2, 3], 4), other.constants([1, 2, 3], 4));
    assert.deepEqual(light.depthMap({ map: light.maps - 1 }), other.depthMap({ map: light.maps - 1 }));
    assert.equal(light.lookup, undefined);
  });
  assert.throws(() => core.open(file.subarray(0, 100)), { code: 'truncated', finding: 106 });
});

test('sizes: the runtime takes at most 68 KB as brotli, core 43 KB', { skip: !fs.existsSync(ESBUILD) && 'no esbuild' }, () => {
  for (const [module, wasm, most] of [['vxs.mjs', 'vxs.wasm', 68000], ['core.mjs', 'core.wasm', 43000]]) {
    const text = execFileSync(ESBUILD, [path.join(PACKAGE, 'runtime', module), '--bundle', '--minify', '--format=esm', '--log-level=error']);
    const size = (data) => zlib.brotliCompressSync(data).length;
    const all = size(text) + size(fs.readFileSync(path.join(PACKAGE, 'runtime', wasm)));
    assert.ok(all <= most, `${module}: ${all} bytes`);
  }
});

test('the WebAssembly asks its host for nothing but reads of streams', async () => {
  for (const [wasm, most] of [['vxs.wasm', ['web_read', 'web_failed']], ['core.wasm', []]]) {
    const module = await WebAssembly.compile(fs.readFileSync(path.join(PACKAGE, 'runtime', wasm)));
    const names = WebAssembly.Module.imports(module).map((i) => `${i.module}.${i.name}`);
    assert.deepEqual(names.sort(), [...most, 'emscripten_notify_memory_growth'].map((name) => `env.${name}`).sort());
  }
});

test('no module evaluates text, touches globals, or loads WebAssembly before load()', async () => {
  const texts = fs.readdirSync(path.join(PACKAGE, 'runtime')).filter((name) => /^(?!shaders|vxs-base64).*\.mjs$/.test(name))
    .map((name) => fs.readFileSync(path.join(PACKAGE, 'runtime', name), 'utf8'));
  assert.ok(texts.length > 6);
  for (const text of texts) assert.doesNotMatch(text, /\beval\b|new Function|globalThis\.\w+ =|process\./);
});
