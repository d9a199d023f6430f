// Streams over HTTP: pages by ranges, budgets, GPU copies; servers that are slow, fail, lie, or have no ranges.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import fs from 'node:fs';
import http from 'node:http';
import { after, before, test } from 'node:test';
import { setTimeout as delay } from 'node:timers/promises';

import { baked, pointsFor, runtime } from './native.mjs';

const { VXSError, load } = await runtime();
const vxs = await load();
const FILE = baked('level', 'city', ['--resolution', '32768']), LEVEL = fs.readFileSync(FILE);
const LAMPS = fs.readFileSync(baked('lamps', 'pillars', ['--resolution', '1024', '--pack', 'fast']));
const DAG = fs.readFileSync(baked('graph', 'pillars', ['--resolution', '256', '--coding', 'dag']));
const SMOKE = fs.readFileSync(baked('smoke', 'smoke', ['--resolution', '256', '--scene-smoke', 'on']));
const MIB = 2 ** 20, BUDGET = 2.75 * MIB, EVERYWHERE = { position: [0, 0, 0] };
const whole = vxs.open(LEVEL), sun = whole.lights[0];

/** Answers of the server by the first part of the path: (request, response, first, end, bytes). */
const KINDS = {
  good: part,
  hidden: (q, r, first, end, bytes) => part(q, r, first, end, bytes, { 'content-range': '' }),
  tagged: (q, r, first, end, bytes) => part(q, r, first, end, bytes, { etag: `"${state.tag}"` }),
  none: (q, r, first, end, bytes) => r.writeHead(200, { 'content-length': bytes.length }).end(bytes),
  absent: (q, r) => r.writeHead(404).end(),
  short: (q, r, first, end, bytes) => part(q, r, first, first + (state.cut(first) ? (end - first) >> 1 : end - first), bytes),
  broken: (q, r, first, end, bytes) => (state.cut(first)
    ? (r.writeHead(206, { 'content-length': end - first, 'content-range': `bytes ${first}-${end - 1}/${bytes.length}` }),
      r.write(bytes.subarray(first, first + 10)), setTimeout(() => r.destroy(), 5)) : part(q, r, first, end, bytes)),
  failing: (q, r, first, end, bytes) => (state.cut(first) ? r.writeHead(503).end() : part(q, r, first, end, bytes)),
  slow: async (q, r, first, end, bytes) => { await delay(state.cut(first) ? 600 : 5); part(q, r, first, end, bytes); },
  wrong: (q, r, first, end, bytes) => {
    const copy = Buffer.from(bytes.subarray(first, end));
    if (state.cut(first)) copy[copy.length >> 1] ^= 1;
    part(q, r, first, end, bytes, {}, copy);
  },
};
const FILES = { level: LEVEL, lamps: LAMPS, dag: DAG, smoke: SMOKE };
const state = { requests: [], tag: 1, cut: () => false };

function part(q, r, first, end, bytes, headers = {}, content = bytes.subarray(first, end)) {
  const all = { 'content-length': content.length,
    'content-range': `bytes ${first}-${first + content.length - 1}/${bytes.length}`, ...headers };
  r.writeHead(206, Object.fromEntries(Object.entries(all).filter(([, value]) => value !== ''))).end(content);
}

const server = http.createServer((q, r) => {
  const [, kind, name] = q.url.split('/'), bytes = FILES[name], [, first, last] = /^bytes=(\d+)-(\d+)$/.exec(q.headers.range);
  state.requests.push({ first: +first, end: Math.min(+last + 1, bytes.length) });
  KINDS[kind](q, r, +first, Math.min(+last + 1, bytes.length), bytes);
});
before(() => new Promise((resolve) => { server.listen(0, '127.0.0.1', resolve); }));
after(() => { server.close(); server.closeAllConnections(); });
const stream = (path, options) => {
  Object.assign(state, { requests: [], tag: 1 });
  return vxs.stream(`http://127.0.0.1:${server.address().port}/${path}`, { budgetBytes: 64 * MIB, ...options });
};

/** Some points, and how many of their lookups differ from those of the whole file, or are not exact. */
const places = pointsFor(whole.lights, 2000);
const POINTS = Float64Array.from({ length: 6000 }, (_, n) => places[6 * Math.floor(n / 3) + n % 3]);
function differences(light, like = sun) {
  const got = light.lookupMany(POINTS, { filter: 9 }), want = like.lookupMany(POINTS, { filter: 9 });
  let full = 0;
  for (let n = 0; n < got.length; n++) full += light.isFull(POINTS.subarray(3 * n, 3 * n + 3), { filter: 9 });
  return { differ: got.filter((lit, n) => !Object.is(lit, want[n])).length, coarse: got.length - full };
}

const finished = (status, { failed = 0 } = {}) => {
  assert.equal(status.pagesFailed, failed);
  assert.equal(status.pagesResident, status.pages - failed);
};

test('a stream: few requests to open, pages by ranges, then the answers of the whole file', async () => {
  const s = await stream('good/level'), light = s.lights[0], opened = state.requests.length;
  assert.ok(opened <= 3, `${opened} requests`);
  assert.ok(state.requests.reduce((sum, r) => sum + r.end - r.first, 0) < LEVEL.length / 2);
  assert.equal(s.ranges, true);
  assert.deepEqual(s.info, whole.info);
  assert.deepEqual([light.name, light.levels, light.firstWord], ['sun', 15, 0]);
  const none = s.frame();
  assert.deepEqual([none.pagesResident, none.pagesWanted, none.pagesMissing], [0, 0, 0]);
  assert.ok(none.pages > 10);
  assert.ok(differences(light).coarse > 200, `${differences(light).coarse} points are coarse`);
  const status = await s.load(EVERYWHERE);
  finished(status);
  assert.deepEqual(differences(light), { differ: 0, coarse: 0 });
  assert.equal(state.requests.length - opened, status.pages);
  assert.ok(status.bytesRead <= LEVEL.length + 100 && status.bytesHeld <= 64 * MIB);
  s.dispose();
});

test('a small budget: pages come and go about a camera, and a copy of the words follows the changes', async () => {
  const s = await stream('good/level', { budgetBytes: BUDGET, requests: 3, decodesPerFrame: 3 });
  const light = s.lights[0], copy = s.words();
  let left = 0;
  for (let n = 0; n < 400; n++) {
    const status = s.frame({ position: [2.5 * n - 500, 5, 0], radius: 400 });
    left += status.left;
    assert.ok(status.bytesHeld <= BUDGET);
    for (const { firstWord, words } of s.changes()) copy.set(words, firstWord);
    await delay(1);
  }
  assert.ok(left > 5, `${left} pages left`);
  const status = await s.load({ min: [0, 0, 1], max: [2, 1, 3], radius: 1 });
  for (const { firstWord, words } of s.changes()) copy.set(words, firstWord);
  assert.deepEqual(s.changes(), []);
  assert.equal(copy.length, s.wordCount);
  const now = s.words();
  // behind pages are some zeros, which are no changes
  const other = now.filter((word, n) => word !== copy[n]);
  assert.ok(other.every((word) => word === 0) && other.length <= 20 * status.pages, `${other.length} words differ`);
  const exact = places.length / 6 - differences(light).coarse, all = { filter: 9 };
  assert.ok(status.pagesMissing > 0 && exact > 200, `${exact} points are exact`);
  for (let n = 0; n < POINTS.length; n += 3) {
    const point = POINTS.subarray(n, n + 3);
    if (light.isFull(point, all)) assert.ok(Object.is(light.lookup(point, all), sun.lookup(point, all)));
  }
  await assert.rejects(stream('good/level', { budgetBytes: 1000 }), { code: 'memory', finding: 211 });
  s.dispose();
});

test('a frame starts all reads that it may, and decodes no more pages than allowed', async () => {
  const s = await stream('slow/level', { requests: 8, decodesPerFrame: 2 }), opened = state.requests.length;
  assert.deepEqual([s.frame(EVERYWHERE).pagesComing, s.frame(EVERYWHERE).decodes], [8, 0]);
  await delay(100);
  assert.equal(state.requests.length - opened, 8);
  assert.equal(s.frame(EVERYWHERE).decodes, 2);
  s.dispose();
});

test('lamps, a DAG, smoke: all lights, or those of names', async () => {
  for (const [name, bytes] of [['lamps', LAMPS], ['dag', DAG], ['smoke', SMOKE]]) {
    const s = await stream(`good/${name}`), all = vxs.open(bytes);
    await s.load(EVERYWHERE);
    all.lights.forEach((light, n) => {
      assert.deepEqual(differences(s.lights[n], light), { differ: 0, coarse: 0 }, `${name} ${light.name}`);
      assert.deepEqual(s.lights[n].smokeLookupMany(POINTS), light.smokeLookupMany(POINTS));
      assert.equal(s.lights[n].hasSmoke, light.hasSmoke);
      const words = new DataView(s.lights[n].constants().buffer);
      assert.equal(words.getUint32(80, true), s.lights[n].firstWord);
    });
    s.dispose();
  }
  const s = await stream('good/lamps', { lights: ['lamp', 'sun'] });
  assert.deepEqual(s.lights.map((l) => l.name), ['lamp', 'sun']);
  await s.load(EVERYWHERE);
  assert.deepEqual(differences(s.light('lamp'), vxs.open(LAMPS).light('lamp')), { differ: 0, coarse: 0 });
  await assert.rejects(stream('good/lamps', { lights: ['moon'] }), { name: 'VXSError', code: 'argument' });
  s.dispose();
});

for (const kind of ['short', 'broken', 'failing', 'slow', 'wrong']) {
  test(`a server that is ${kind} at first: reads are tried again`, async () => {
    const seen = new Map();
    state.cut = (first) => {
      seen.set(first, (seen.get(first) ?? 0) + 1);
      return seen.get(first) < 3 && seen.size % 3 === 1;
    };
    if (kind === 'wrong') state.cut = () => false;
    const s = await stream(`${kind}/level`, { timeoutMs: 200 });
    if (kind === 'wrong') state.cut = () => true;
    let status = await s.load(EVERYWHERE);
    if (kind === 'wrong') {
      assert.equal(status.pagesFailed, status.pages);
      assert.equal(status.failures.length, 0);
      assert.ok(differences(s.lights[0]).coarse > 0);
      assert.deepEqual([...new Set(s.lights[0].lookupMany(POINTS))].filter(Number.isNaN), []);
      state.cut = () => false;
      s.retry();
      status = await s.load(EVERYWHERE);
    }
    finished(status);
    assert.deepEqual(differences(s.lights[0]), { differ: 0, coarse: 0 });
    assert.ok(kind === 'wrong' || [...seen.values()].some((count) => count > 1));
    state.cut = () => false;
    s.dispose();
  });
}

test('pages that stay away are reported, and their lookups stay coarse', async () => {
  state.cut = () => false;
  const s = await stream('failing/level', { requests: 64 }), far = [];
  state.cut = () => true;
  let status, frames = 0;
  do {
    status = s.frame(EVERYWHERE);
    far.push(...status.failures);
    await delay(1);
  } while (++frames < 2000 && far.length < 6 * status.pages);
  assert.equal(far.length, 6 * status.pages);
  assert.ok(far.every(({ code, light, finding }) => code === 'read' && light === 0 && finding === 0));
  assert.equal(status.pagesFailed, status.pages);
  assert.ok(differences(s.lights[0]).coarse > 200);
  state.cut = () => false;
  s.retry();
  finished(await s.load(EVERYWHERE));
  s.dispose();
});

test('a server without ranges: the whole file is downloaded once, and the stream says so', async () => {
  const s = await stream('none/level');
  assert.equal(s.ranges, false);
  finished(await s.load(EVERYWHERE));
  assert.equal(state.requests.length, 1);
  assert.deepEqual(differences(s.lights[0]), { differ: 0, coarse: 0 });
  s.dispose();
});

test('a server of another origin that hides content-range: the file itself says its size', async () => {
  const s = await stream('hidden/level');
  finished(await s.load(EVERYWHERE));
  assert.deepEqual(differences(s.lights[0]), { differ: 0, coarse: 0 });
  s.dispose();
});

test('errors of opening: no server, no file, other bytes, a file that changes', async () => {
  const error = (promise) => promise.then(() => assert.fail('opened'), (e) => e);
  const absent = await error(stream('absent/level'));
  assert.ok(absent instanceof VXSError && absent.code === 'read' && /HTTP status 404/.test(absent.message), absent.message);
  const nowhere = await error(vxs.stream('http://127.0.0.1:1/level', { budgetBytes: MIB }));
  assert.ok(nowhere instanceof VXSError && nowhere.code === 'read' && nowhere.cause, nowhere.message);
  FILES.text = Buffer.from('not a file of shadows'.repeat(10));
  assert.equal((await error(stream('good/text'))).code, 'notVxs');
  FILES.empty = Buffer.alloc(0);
  assert.equal((await error(stream('none/empty'))).code, 'truncated');
  FILES.cut = LEVEL.subarray(0, 150000);
  assert.equal((await error(stream('good/cut'))).finding, 106);
  FILES.bad = Buffer.from(LEVEL);
  FILES.bad[300] ^= 1;
  const bad = await error(stream('good/bad'));
  assert.throws(() => vxs.open(FILES.bad), { code: bad.code, finding: bad.finding });
  const s = await stream('tagged/level');
  state.tag = 2;
  const status = await s.load(EVERYWHERE);
  assert.equal(status.pagesResident, 0);
  state.tag = 1;
  s.retry();
  finished(await s.load(EVERYWHERE));
  s.dispose();
});

test('arguments; a signal; disposal while reads are in progress', async () => {
  const url = 'http://127.0.0.1:1/';
  for (const [options, kind] of [[undefined, RangeError], [{}, RangeError],
    [{ budgetBytes: NaN }, RangeError], [{ budgetBytes: -1 }, RangeError],
    [{ budgetBytes: MIB, requests: 65 }, RangeError], [{ budgetBytes: MIB, decodesPerFrame: 0 }, RangeError],
    [{ budgetBytes: MIB, lights: 'sun' }, TypeError], [{ budgetBytes: MIB, lights: [] }, TypeError],
    [{ budgetBytes: MIB, fetch: 1 }, TypeError]]) {
    await assert.rejects(vxs.stream(url, options), kind);
  }
  const reason = new Error('enough');
  await assert.rejects(stream('good/level', { signal: AbortSignal.abort(reason) }), (e) => e === reason);
  state.cut = () => true;
  const stop = new AbortController(), opening = stream('slow/level', { signal: stop.signal });
  setTimeout(() => stop.abort(reason), 50);
  await assert.rejects(opening, (e) => e === reason);
  state.cut = () => false;
  const before = vxs.memoryBytes;
  for (let n = 0; n < 30; n++) {
    const s = await stream('slow/level', { budgetBytes: 2 * MIB });
    s.frame(EVERYWHERE);
    if (n % 2) await delay(n);
    s.dispose();
    s.dispose();
    assert.throws(() => s.frame(), { code: 'disposed' });
    assert.throws(() => s.lights[0].lookup([0, 0, 0]), { code: 'disposed' });
    assert.throws(() => s.words(), { code: 'disposed' });
  }
  await delay(50);
  assert.ok(vxs.memoryBytes - before < 8 * MIB, `${vxs.memoryBytes - before}`);
  const s = await stream('good/level');
  for (const foci of [{ position: [0, 0] }, { position: [0, 0, 0], radius: -1 }, { position: [0, 0, 0], weight: 0 }, [1]]) {
    assert.throws(() => s.frame(foci), (e) => e instanceof TypeError || e instanceof RangeError);
  }
  assert.equal(s.frame({ position: [NaN, 0, 0] }).pagesWanted, 0);
  s.dispose();
});

test('two streams and a file of one instance do not meet; a fetch of the caller is used', async () => {
  let calls = 0;
  const own = (url, init) => { calls++; return fetch(url, init); };
  const [a, b] = await Promise.all([stream('good/level', { fetch: own }), stream('good/lamps')]);
  await Promise.all([a.load(EVERYWHERE), b.load(EVERYWHERE)]);
  assert.ok(calls > 10);
  assert.deepEqual(differences(a.lights[0]), { differ: 0, coarse: 0 });
  assert.deepEqual(differences(b.light('lamp'), vxs.open(LAMPS).light('lamp')), { differ: 0, coarse: 0 });
  a.dispose();
  assert.deepEqual(differences(b.light('sun'), vxs.open(LAMPS).light('sun')), { differ: 0, coarse: 0 });
  b.dispose();
});
