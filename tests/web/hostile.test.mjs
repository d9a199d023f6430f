// Wrong and hostile files through the runtime as WebAssembly: the results of the C library, in bounded memory.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';

import { baked, folder, openings, randomly, runtime } from './native.mjs';

const { VXSError, load } = await runtime();
const RESULTS = { memory: 2, read: 3, notVxs: 10, version: 11, truncated: 12, corrupt: 13 };
const EVERY = process.env.VXS_TEST_REPEATS === 'all';
const MIB = 2 ** 20;

/** Opens a file. Returns its result in the form of openings(). Asks some lookups of a good one. */
function opening(vxs, bytes) {
  try {
    const asset = vxs.open(bytes);
    for (const light of asset.lights) {
      light.lookupMany(new Float64Array(30), { filter: 9 });
      light.depthMap({ map: light.maps - 1, resolution: Math.min(16, light.resolution) });
      light.intervals([1, 2, 3], [1, -1, 0.5], 0, 1000);
    }
    asset.dispose();
    return { result: 0, finding: 0, section: -1, offset: 0 };
  } catch (error) {
    assert.ok(error instanceof VXSError, String(error));
    const { code, finding, section, offset } = error;
    assert.ok(!finding || error.message.endsWith(`(finding ${finding})`));
    return { result: RESULTS[code], finding, section, offset };
  }
}

async function compare(files) {
  const vxs = await load(), want = openings(files);
  files.forEach((file, n) => assert.deepEqual(opening(vxs, fs.readFileSync(file)), want[n], file));
  return { vxs, want };
}

test('the corpus of the fuzzer: the same result, finding, section and offset as in C', async () => {
  const corpus = path.resolve(import.meta.dirname ?? path.dirname(new URL(import.meta.url).pathname), '../fuzz/corpus/vxs.tar.xz');
  execFileSync('tar', ['xJf', corpus, '-C', folder]);
  const files = fs.readdirSync(path.join(folder, 'vxs')).sort().map((name) => path.join(folder, 'vxs', name));
  const { vxs, want } = await compare(files);
  assert.ok(files.length > 300 && new Set(want.map((w) => w.finding)).size > 30);
  assert.ok(want.some((w) => w.result === 0));
  assert.ok(vxs.memoryBytes < 160 * MIB, `${vxs.memoryBytes}`);
});

const SHARED = path.resolve(process.env.VXS_SCENES ?? '../shared/scenes', '../cases/hostile');
test('shared hostile files', { skip: !fs.existsSync(SHARED) && `there is no ${SHARED}` }, async () => {
  const found = fs.readdirSync(SHARED, { recursive: true }).filter((file) => file.endsWith('.vxs'));
  assert.ok(found.length);
  await compare(found.map((file) => path.join(SHARED, file)));
});

test('changed files: each prefix, flipped bit and overwritten word gives what C gives', async () => {
  const random = randomly(7), files = [];
  for (const [name, options] of [['small', []], ['fast', ['--pack', 'fast']], ['dag', ['--coding', 'dag']]]) {
    const good = fs.readFileSync(baked(`h${name}`, 'pillars', ['--resolution', '64', ...options]));
    for (let n = 0; n < (EVERY ? 2000 : 100); n++) {
      const bytes = Buffer.from(good), at = Math.floor(random() * (n % 2 ? 2000 : good.length));
      if (n % 4 === 0) bytes[at % good.length] ^= 1 << n % 8;
      if (n % 4 === 1) bytes.writeUInt32LE(Math.floor(random() * 2 ** 32), Math.min(at, good.length - 4));
      if (n % 4 === 2) bytes.writeUInt32LE(0xffffffff, Math.min(at, good.length - 4));
      if (n % 4 !== 3 && bytes.equals(good)) continue; // the word was there already
      const file = path.join(folder, `${name}_${n}`);
      fs.writeFileSync(file, n % 4 === 3 ? bytes.subarray(0, at) : bytes);
      files.push(file);
    }
  }
  const { want } = await compare(files);
  assert.ok(want.every((w) => w.result));
});

test('a kilobyte that claims 2 GB of words is an error, and takes no memory', async () => {
  const good = fs.readFileSync(baked('claims', 'pillars', ['--resolution', '64', '--coding', 'dag'])), vxs = await load();
  const before = vxs.memoryBytes, claims = (bytes) => assert.throws(() => vxs.open(bytes), (e) => e instanceof VXSError);
  const entry = 64 + 48 * 2; // of the directory: sizes in the file and in memory
  for (const [at, value] of [[12, 20480], [12, 0xffffffff], [16, 0x7fffffff], [entry + 24, 0x7fffffff], [entry + 32, 0x7fffffff]]) {
    const bytes = Buffer.from(good.subarray(0, 1024));
    bytes.writeUInt32LE(value, at);
    claims(bytes);
  }
  assert.equal(vxs.memoryBytes, before);
  // with good checksums, so that the claim itself is read
  const file = path.join(folder, 'claim.vxs');
  fs.writeFileSync(file, claimOf(2 ** 31 - 1));
  assert.ok(fs.statSync(file).size < 1024);
  const [want] = openings([file]);
  assert.deepEqual([want.result, want.finding], [2, 211]);
  assert.deepEqual(opening(vxs, fs.readFileSync(file)), want);
  assert.ok(vxs.memoryBytes - before < 2 * MIB, `${vxs.memoryBytes - before}`);
});

/** A file whose table of lights is said to inflate to so many bytes, with all checksums right. */
function claimOf(size) {
  const frame = Buffer.from('28b52ffd', 'hex'), head = Buffer.alloc(64), entry = Buffer.alloc(48);
  const stored = Buffer.concat([frame, Buffer.from([0xa0]), u32(size), Buffer.from([1, 0, 0])]); // one block without bytes
  entry.writeUInt32LE(0x5448474c, 0);
  entry.writeUInt32LE(0xffffffff, 8);
  entry.writeBigUInt64LE(112n, 16);
  entry.writeBigUInt64LE(BigInt(stored.length), 24);
  entry.writeBigUInt64LE(BigInt(size), 32);
  entry.writeBigUInt64LE(xxh64(stored), 40);
  head.write('\x8fVXS\r\n\x1a\n', 'latin1');
  head.writeUInt32LE(1, 8);
  head.writeUInt32LE(1, 12);
  head.writeBigUInt64LE(BigInt(112 + stored.length), 16);
  head.writeBigUInt64LE(xxh64(entry), 24);
  head.writeBigUInt64LE(xxh64(head.subarray(0, 56)), 56);
  return Buffer.concat([head, entry, stored]);
}

const u32 = (value) => Buffer.from(Uint32Array.of(value).buffer);

/** XXH64 with seed 0. */
function xxh64(bytes) {
  const P = [0x9e3779b185ebca87n, 0xc2b2ae3d27d4eb4fn, 0x165667b19e3779f9n, 0x85ebca77c2b2ae63n, 0x27d4eb2f165667c5n];
  const cut = (x) => BigInt.asUintN(64, x), turn = (x, n) => cut(x << n | x >> (64n - n));
  const round = (a, x) => cut(turn(cut(a + cut(x * P[1])), 31n) * P[0]);
  let at = 0, h = P[4];
  if (bytes.length >= 32) {
    const v = [cut(P[0] + P[1]), P[1], 0n, cut(-P[0])];
    for (; at + 32 <= bytes.length; at += 32) for (let n = 0; n < 4; n++) v[n] = round(v[n], bytes.readBigUInt64LE(at + 8 * n));
    h = cut(turn(v[0], 1n) + turn(v[1], 7n) + turn(v[2], 12n) + turn(v[3], 18n));
    for (const x of v) h = cut((h ^ round(0n, x)) * P[0] + P[3]);
  }
  h = cut(h + BigInt(bytes.length));
  for (; at + 8 <= bytes.length; at += 8) h = cut(turn(h ^ round(0n, bytes.readBigUInt64LE(at)), 27n) * P[0] + P[3]);
  if (at + 4 <= bytes.length) {
    h = cut(turn(h ^ cut(BigInt(bytes.readUInt32LE(at)) * P[0]), 23n) * P[1] + P[2]);
    at += 4;
  }
  for (; at < bytes.length; at++) h = cut(turn(h ^ cut(BigInt(bytes[at]) * P[4]), 11n) * P[0]);
  h = cut((h ^ h >> 33n) * P[1]);
  h = cut((h ^ h >> 29n) * P[2]);
  return h ^ h >> 32n;
}

test('the limit of memory: what C says of it, and nothing above it', async () => {
  const bytes = fs.readFileSync(baked('limit', 'city', ['--resolution', '4096'])), vxs = await load(), before = vxs.memoryBytes;
  assert.throws(() => vxs.open(bytes, { memoryLimit: 300000 }), { code: 'memory', finding: 211 });
  assert.ok(vxs.memoryBytes - before < 300000 + bytes.length + 4 * 65536, `${vxs.memoryBytes - before}`);
  vxs.open(bytes, { memoryLimit: 4 * MIB }).dispose();
});
