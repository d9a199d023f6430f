// The command under Node, bin/vxs.mjs, beside the native one: bytes, reports, messages, exit statuses; pipes, limits of memory, signals.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { spawn, spawnSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { after, test } from 'node:test';
import { setTimeout as delay } from 'node:timers/promises';
import zlib from 'node:zlib';

const VXS = process.env.VXS ?? path.resolve('build/release/vxs');
const PACKAGE = process.env.VXS_PACKAGE ?? path.resolve('build/web/vxs');
const SCENES = process.env.VXS_SCENES ?? path.resolve('../shared/scenes');
const EVERY = process.env.VXS_TEST_REPEATS === 'all';
const COMMAND = path.join(PACKAGE, 'bin/vxs.mjs');
const PROGRAMS = { native: [VXS], web: [process.execPath, COMMAND] };

const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-command-'));
after(() => fs.rmSync(folder, { recursive: true }));
const at = (...names) => path.join(folder, ...names);

/** Runs a program of PROGRAMS in a folder. Returns { status, signal, output, errors }. */
function run(kind, args, { input, cwd = folder, env = {} } = {}) {
  const [program, ...first] = PROGRAMS[kind];
  const child = spawn(program, [...first, ...args], { cwd, env: { ...process.env, VXS_CPU: 'sse2', ...env } });
  const parts = { stdout: [], stderr: [] };
  for (const name of ['stdout', 'stderr']) child[name].on('data', (data) => parts[name].push(data));
  child.stdin.on('error', () => {}); // a command that fails early leaves its input unread
  child.stdin.end(input);
  return new Promise((resolve, reject) => {
    child.on('error', reject);
    child.on('close', (status, signal) =>
      resolve({ status, signal, output: Buffer.concat(parts.stdout), errors: Buffer.concat(parts.stderr).toString() }));
  });
}

/** A text without what differs between two runs of one build, or follows from the number of threads: times, memory. */
const steady = (bytes) => bytes.toString('latin1')
  .replace(/^(time|estimate) .*$|^(\w+ +[\d.]+ m?s +[\d.]+ [KM]iB) .*$/gm, '')
  .replace(/"(threads|\w*seconds|(peak|least|held)_bytes|cpu_class)": [^,}\]\n]+/g, '"$1": 0');

/** Runs both, each in a folder of its own with links to `files`. Everything that they print and write must be equal. */
async function both(args, { files = [], ...options } = {}) {
  const results = {};
  await Promise.all(Object.keys(PROGRAMS).map(async (kind) => {
    const cwd = fs.mkdtempSync(at(`${kind}-`));
    for (const file of files) fs.linkSync(file, path.join(cwd, path.basename(file)));
    const result = await run(kind, args, { ...options, cwd });
    const written = fs.readdirSync(cwd, { recursive: true }).sort()
      .filter((name) => fs.statSync(path.join(cwd, name)).isFile() && !files.some((file) => path.basename(file) === name));
    results[kind] = { ...result, files: Object.fromEntries(written.map((name) => [name, fs.readFileSync(path.join(cwd, name))])) };
    fs.rmSync(cwd, { recursive: true });
  }));
  const { native, web } = results;
  const line = args.join(' ');
  assert.equal(web.errors, native.errors, line);
  assert.equal(web.status, native.status, line);
  assert.equal(steady(web.output), steady(native.output), line);
  assert.deepEqual(Object.keys(web.files), Object.keys(native.files), line);
  for (const name of Object.keys(native.files)) {
    const [a, b] = [native.files[name], web.files[name]];
    assert.ok(name.endsWith('.json') ? steady(a) === steady(b) : a.equals(b), `${line}: ${name} differs`);
  }
  return web;
}

function generate(name, ...args) {
  const made = spawnSync(VXS, ['scene', ...args, '-o', at(name), '--quiet']);
  assert.equal(made.status, 0, made.stderr.toString());
  return at(name);
}
const city = generate('city.glb', 'city', '--triangles', '5000');
const largerCity = generate('larger_city.glb', 'city', '--triangles', '50000'); // for bakes of seconds
const lamps = generate('lamps.glb', 'city', '--triangles', '2000', '--spots', '2');
const room = generate('room.glb', 'room', '--triangles', '3000');
const forest = generate('forest.glb', 'forest', '--triangles', '4000');
const smoke = generate('smoke.glb', 'smoke', '--capsules', '500');
const asset = at('city.vxs');
spawnSync(VXS, ['bake', city, '-o', asset, '--resolution', '1024', '--quiet']);

const bakeOn = (threads, scene, ...options) =>
  ['bake', path.basename(scene), '-o', 'out.vxs', '--json', 'out.json', '--threads', String(threads), ...options];
const bake = (scene, ...options) => bakeOn(1, scene, ...options);

test('bakes have the same bytes, reports and messages', async (t) => {
  const lines = [
    [city, '--resolution', '2048'],
    [city, '--resolution', '1024', '--coding', 'dag'],
    [city, '--resolution', '1024', '--coding', 'dag', '--stop', 'partial', '--rule', 'shadow', '--level', '3'],
    [city, '--texel', '1.5', '--pack', 'fast', '--verbose'],
    [city, '--resolution', '512', '--closed', 'off', '--thickness', '0.5', '--behind', 'free'],
    [city, '--resolution', '512', '--sun', 'noon=0.1,-1,0.05', '--light', 'noon', '--points', '2000'],
    [city, '--resolution', '512', '--region', '-50,0,-50,50,30,50', '--exclude', 'node:*1', '--strict'],
    [forest, '--resolution', '512'],
    [lamps, '--resolution', '256'],
    [room, '--resolution', '512'],
    [smoke, '--resolution', '256', '--scene-smoke', 'on', '--sun', '0.3,-1,0.2'],
  ];
  for (const [scene, ...options] of lines)
    await t.test(`${path.basename(scene)} ${options.join(' ')}`, () => both(bake(scene, ...options), { files: [scene] }));
});

test('bakes on four threads have the same bytes, reports and messages', async (t) => {
  const lines = [
    [city, '--resolution', '4096'],
    [city, '--resolution', '1024', '--coding', 'dag'],
    [city, '--resolution', '1024', '--resume', 'cache', '--pack', 'fast'],
    [city, '--resolution', '1024', '--memory', '1G', '--points', '2000', '--verbose'],
    [forest, '--resolution', '1024'],
    [lamps, '--resolution', '512'],
    [room, '--resolution', '512'],
    [smoke, '--resolution', '256', '--scene-smoke', 'on', '--sun', '0.3,-1,0.2'],
  ];
  for (const [scene, ...options] of lines)
    await t.test(`${path.basename(scene)} ${options.join(' ')}`, () => both(bakeOn(4, scene, ...options), { files: [scene] }));
});

/** Runs the command on files of `folder`; `patch` is a module that Node runs before it. */
const runPatched = (patch, args, options) =>
  run('web', args, { env: { NODE_OPTIONS: `--import=data:text/javascript,${encodeURIComponent(patch)}` }, ...options });
/** A patch: threads are made by `make`, from the class Worker, a URL and options. */
const patchOf = (make) => `
  import workers from 'node:worker_threads';
  import { syncBuiltinESMExports } from 'node:module';
  const { Worker } = workers;
  const make = ${make};
  workers.Worker = function (url, options) {
    return String(url).endsWith('/thread_worker.mjs') ? make(Worker, url, options) : new Worker(url, options);
  };
  syncBuiltinESMExports();`;

test('threads that cannot be started are no error', async () => {
  const line = ['bake', city, '-o', 'few.vxs', '--resolution', '1024', '--quiet', '--threads', '4'];
  const none = await runPatched(patchOf("() => { throw new Error('no thread') }"), line);
  assert.deepEqual([none.status, none.errors], [0, '']);
  assert.ok(fs.readFileSync(at('few.vxs')).equals(fs.readFileSync(asset)));
  const late = await runPatched(patchOf("(Worker, url, options) => new Worker(new URL('./missing.mjs', url), options)"), line);
  assert.deepEqual([late.status, late.errors], [0, '']);
});

test('a thread that fails ends the command, and no file is left', async () => {
  const failing = "import { parentPort as p } from 'node:worker_threads'; p.once('message', () => p.postMessage({ status: 134, messages: 'vxs: error: it broke\\n' }))";
  const patch = patchOf(`(Worker, url, options) => new Worker(new URL(${JSON.stringify(`data:text/javascript,${encodeURIComponent(failing)}`)}), options)`);
  const before = fs.readdirSync(folder);
  const line = ['bake', city, '-o', 'broken-thread.vxs', '--resolution', '65536', '--texel', 'sun=0.01', '--quiet', '--threads', '2'];
  const { status, errors } = await runPatched(patch, line);
  assert.deepEqual([status, errors], [134, 'vxs: error: it broke\n']);
  assert.deepEqual(fs.readdirSync(folder), before);
});

/** Seconds of processor time of the threads of a run, most first. */
async function secondsOfThreads(args) {
  const child = spawn(process.execPath, [COMMAND, ...args], { cwd: folder, stdio: 'ignore' });
  const seconds = new Map();
  while (child.exitCode === null) {
    await delay(5);
    for (const task of fs.existsSync(`/proc/${child.pid}/task`) ? fs.readdirSync(`/proc/${child.pid}/task`) : [])
      try {
        seconds.set(task, Number(fs.readFileSync(`/proc/${child.pid}/task/${task}/schedstat`, 'utf8').split(' ')[0]) / 1e9);
      } catch {
        // it has ended
      }
  }
  assert.equal(child.exitCode, 0);
  return [...seconds.values()].sort((a, b) => b - a);
}

test('threads share the work', { skip: !fs.existsSync('/proc/self/task') && 'there is no /proc/self/task' }, async () => {
  const line = ['bake', largerCity, '-o', 'shared.vxs', '--resolution', '65536', '--quiet', '--threads'];
  const [alone, helper] = await secondsOfThreads([...line, '1']); // one that compiles
  const [first, second] = await secondsOfThreads([...line, '2']);
  assert.ok(helper < 0.4 * alone && second > 0.5 * first && first < 0.8 * alone, `${[alone, helper, first, second]}`);
});

test('a fine map, whose texels 32 bits cannot count', { skip: !EVERY && 'VXS_TEST_REPEATS is not all' }, () =>
  both(bake(city, '--resolution', '131072'), { files: [city] }));

test('plan, info, validate, query, export, merge and view say the same', async () => {
  const files = [city, asset];
  await both(['plan', 'city.glb'], { files });
  await both(['info', 'city.vxs'], { files });
  await both(['info', 'city.vxs', '--json', '-'], { files });
  await both(['validate', 'city.vxs'], { files });
  await both(['query', 'city.vxs', '--filter', '3'], { files, input: '0 1 0\n10 5 3\nnonsense\n' });
  await both(['query', 'city.vxs'], { files, input: Array.from({ length: 3000 }, (_, i) => `${i % 97} ${i % 13} ${i % 89}\n`).join('') });
  const exported = await both(['export', 'city.vxs', '-o', 'folder', '--depth', '256', '--format', 'raw', '--axes', 'unreal'], { files });
  assert.equal(Object.keys(exported.files).length, 4);
  const parts = [at('1.part'), at('2.part')];
  for (const [n, part] of parts.entries()) {
    const done = await run('web', ['bake', city, '-o', part, '--part', `${n + 1}/2`, '--resolution', '1024', '--quiet']);
    assert.deepEqual([done.status, done.errors], [0, '']);
  }
  const merged = await both(['merge', '1.part', '2.part', '-o', 'out.vxs'], { files: parts });
  assert.ok(merged.files['out.vxs'].length > 1000);
});

test('wrong command lines and files get the same messages and exit statuses', async () => {
  const broken = at('broken.vxs');
  const bytes = fs.readFileSync(asset);
  bytes[bytes.length >> 1] ^= 4;
  fs.writeFileSync(broken, bytes);
  fs.writeFileSync(at('text.glb'), 'not a scene');
  const files = [city, broken, at('text.glb')];
  const lines = [
    ['bake'], ['bake', 'city.glb'], ['bake', 'none.glb', '-o', 'x.vxs'], ['bake', 'text.glb', '-o', 'x.vxs'], ['bkae'],
    ['bake', 'city.glb', '-o', 'x.vxs', '--resolution', '1000'], ['bake', 'city.glb', '-o', 'x.vxs', '--reslution', '1024'],
    ['bake', 'city.glb', '-o', 'city.glb'], ['bake', 'city.glb', '-o', 'no/folder/x.vxs'], ['bake', 'city.glb', '-o', ''],
    ['bake', 'city.glb', '-o', '.'], ['bake', '.', '-o', 'x.vxs'], ['bake', 'city.glb', '-o', 'x.vxs', '--light', 'moon'],
    ['bake', 'city.glb', '-o', 'x.vxs', '--json', 'x.vxs'], ['info', 'none.vxs'], ['info', 'city.glb'], ['validate', 'broken.vxs'],
    ['query', 'broken.vxs'], ['merge', 'city.glb', '-o', 'x.vxs'], ['bake', 'city.glb', '-o', 'broken.vxs/x.vxs'],
    ['bake', 'city.glb', '-o', `${'x'.repeat(300)}.vxs`],
  ];
  for (const line of lines) {
    const { status } = await both(line, { files });
    assert.notEqual(status, 0, line.join(' '));
  }
});

test('a file that asks for more than the address space is refused', async () => {
  // 2^26 triangles of 3 * 2^26 vertices without data: 32 bits cannot count the bytes that they need
  const count = 3 << 20;
  const json = {
    asset: { version: '2.0' },
    scenes: [{ nodes: Array.from({ length: 64 }, (_, i) => i) }],
    nodes: Array.from({ length: 64 }, () => ({ mesh: 0 })),
    meshes: [{ primitives: [{ attributes: { POSITION: 0 } }] }],
    accessors: [{ componentType: 5126, type: 'VEC3', count, min: [0, 0, 0], max: [0, 0, 0] }],
  };
  fs.writeFileSync(at('many.gltf'), JSON.stringify(json));
  const { status, errors } = await run('web', ['bake', 'many.gltf', '-o', 'many.vxs', '--sun', '0,-1,0']);
  assert.equal(status, 6, errors);
  assert.match(errors, /67108864 triangles with 201326592 vertices.* needs about 13\.\d GiB of memory/);
});

test('standard input and output are pipes, whole or slow', async () => {
  const scene = fs.readFileSync(city);
  const expected = (await run('native', ['bake', city, '-o', '-', '--resolution', '512', '--quiet'])).output;
  const piped = await run('web', ['bake', '-', '-o', '-', '--resolution', '512', '--quiet'], { input: scene });
  assert.deepEqual([piped.status, piped.errors], [0, '']);
  assert.ok(piped.output.equals(expected));

  // a pipe that does not block, as some programs leave theirs
  const unblock = 'import os, sys; os.set_blocking(0, False); os.execv(sys.argv[1], sys.argv[1:])';
  const slow = spawn('/usr/bin/python3', ['-c', unblock, process.execPath, COMMAND, 'info', '-']);
  const parts = [];
  slow.stdout.on('data', (data) => parts.push(data));
  const bytes = fs.readFileSync(asset);
  for (let i = 0; i < 4; i++) {
    slow.stdin.write(bytes.subarray((i * bytes.length) >> 2, ((i + 1) * bytes.length) >> 2));
    await delay(i ? 50 : 1500); // the command waits for the second part
  }
  slow.stdin.end();
  assert.equal(await new Promise((resolve) => slow.on('close', resolve)), 0);
  assert.equal(Buffer.concat(parts).toString(), (await run('native', ['info', '-'], { input: bytes })).output.toString());
});

test('a reader that closes the pipe ends a query quietly, as natively', async () => {
  const points = Array.from({ length: 200000 }, (_, i) => `${i % 97} ${i % 13} ${i % 89}\n`).join('');
  fs.writeFileSync(at('points'), points);
  const status = (program) => spawnSync('/bin/bash', ['-c', `${program} query city.vxs <points | head -n 1; echo \${PIPESTATUS[0]}`],
    { cwd: folder });
  const web = status(`'${process.execPath}' '${COMMAND}'`);
  const native = status(`'${VXS}'`);
  assert.deepEqual([web.stdout.toString(), web.stderr.toString()], [native.stdout.toString(), native.stderr.toString()]);
});

test('--memory is kept', async () => {
  const line = ['bake', city, '-o', 'memory.vxs', '--resolution', '1024', '--quiet', '--memory'];
  const refused = await run('web', [...line, '2M']);
  assert.equal(refused.status, 6);
  assert.match(refused.errors, /^vxs: error: .*--memory .*2\.00 MiB.*\n$/);
  assert.ok(!fs.existsSync(at('memory.vxs')));
  const kept = await run('web', [...line, '1G']);
  assert.deepEqual([kept.status, kept.errors], [0, '']);
  assert.ok(fs.readFileSync(at('memory.vxs')).equals(fs.readFileSync(asset)));
});

test('an output is replaced as a whole, with its permissions', async () => {
  const output = at('kept.vxs');
  fs.writeFileSync(output, 'old');
  fs.chmodSync(output, 0o640);
  await run('web', ['bake', city, '-o', output, '--resolution', '1024', '--quiet']);
  assert.equal(fs.statSync(output).mode & 0o777, 0o640);
  assert.ok(fs.readFileSync(output).equals(fs.readFileSync(asset)));
  fs.linkSync(output, at('twin.vxs'));
  for (const kind of Object.keys(PROGRAMS)) {
    const { status, errors } = await run(kind, ['bake', city, '-o', output, '--resolution', '512', '--quiet']);
    assert.deepEqual([status, errors], [4, `vxs: error: ${output}: cannot write: it is one of 2 hard links to a file: --force replaces this one alone\n`]);
  }
});

test('a full disk fails as natively', { skip: !fs.existsSync('/dev/full') && 'there is no /dev/full' }, async () => {
  await both(['bake', 'city.glb', '-o', '/dev/full', '--resolution', '512', '--quiet'], { files: [city] });
  const line = `bake ${city} -o - --resolution 512 --quiet >/dev/full`;
  const [native, web] = Object.values(PROGRAMS).map((program) => spawnSync('/bin/bash', ['-c', `'${program.join("' '")}' ${line}`]));
  assert.deepEqual([web.status, web.stderr.toString()], [native.status, native.stderr.toString()]);
  assert.equal(web.status, 4);
});

/** Starts a long bake into a folder, and calls act(child, folder) when its temporary file may be there. Returns how it ended. */
async function interrupted(kind, signal, threads = 1) {
  const cwd = fs.mkdtempSync(at('signal-'));
  const [program, ...first] = PROGRAMS[kind];
  const child = spawn(program, [...first, 'bake', largerCity, '-o', 'out.vxs', '--resolution', '262144', '--threads', String(threads)], { cwd });
  const ended = new Promise((resolve) => child.on('close', (status, by) => resolve({ status, by })));
  await delay(1200);
  child.kill(signal);
  const end = await ended;
  const left = fs.readdirSync(cwd);
  fs.rmSync(cwd, { recursive: true });
  return { ...end, left };
}

test('a signal ends a bake as natively, and leaves no file', async () => {
  for (const [signal, end] of [['SIGINT', { status: 130, by: null }], ['SIGTERM', { status: null, by: 'SIGTERM' }],
    ['SIGHUP', { status: null, by: 'SIGHUP' }], ['SIGKILL', { status: null, by: 'SIGKILL' }]])
    for (const threads of [1, 3]) assert.deepEqual(await interrupted('web', signal, threads), { ...end, left: [] }, `${signal} ${threads}`);
});

test('a signal while the output is written leaves no temporary file', async () => {
  const scene = generate('large.glb', 'city', '--triangles', '400000');
  fs.writeFileSync(at('page.html'), '<html><!--vxs:level:1--></html>');
  let caught = 0;
  for (let n = 0; n < 10 && !caught; n++) {
    const cwd = fs.mkdtempSync(at('commit-'));
    const large = () => fs.readdirSync(cwd).some((name) => name.endsWith('.tmp') && fs.statSync(path.join(cwd, name), { throwIfNoEntry: false })?.size > 1e5);
    const child = spawn(process.execPath, [COMMAND, 'view', scene, asset, '-o', 'out.html', '--page', at('page.html')], { cwd, stdio: 'ignore' });
    const ended = new Promise((resolve) => child.on('close', resolve));
    while (child.exitCode === null && !large()) await delay(1);
    child.kill('SIGINT');
    const status = await ended;
    caught += status === 130;
    assert.deepEqual(fs.readdirSync(cwd), status === 130 ? [] : ['out.html'], `status ${status}`);
  }
  assert.equal(caught, 1);
});

test('the WebAssembly is at most 2.2 MB, 0.65 MB with brotli; with threads 2.25 and 0.66', () => {
  for (const [name, raw, most] of [['vxs', 2.2e6, 0.65e6], ['vxs-threads', 2.25e6, 0.66e6]]) {
    const bytes = fs.readFileSync(path.join(PACKAGE, `baker/${name}.wasm`));
    const packed = zlib.brotliCompressSync(bytes, { params: { [zlib.constants.BROTLI_PARAM_SIZE_HINT]: bytes.length } });
    assert.ok(bytes.length <= raw, `${name}: ${bytes.length} bytes`);
    assert.ok(packed.length <= most, `${name}: ${packed.length} bytes with brotli`);
  }
});

test('scenes that need exact predicates, or are hard in other ways', async (t) => {
  const some = ['touching-27', 'common-planes-50', 'crossing-itself', 'near-far', 'light-in-wall', 'checkered-masks'];
  const all = () => spawnSync(VXS, ['scene', 'stress', '--case', 'list']).stdout.toString().trim().split('\n').map((line) => line.split(' ')[0]);
  for (const name of EVERY ? all() : some) {
    const scene = generate(`${name}.glb`, 'stress', '--case', name);
    for (const threads of ['1', '4'])
      await t.test(`${name}, ${threads}`, () => both(['bake', `${name}.glb`, '-o', 'out.vxs', '--resolution', '512', '--quiet', '--threads', threads], { files: [scene] }));
  }
});

const shared = !fs.existsSync(SCENES) && `there is no ${SCENES}`;
function scenesIn(name) {
  const found = fs.readdirSync(path.join(SCENES, name), { recursive: true }).filter((file) => /\.(glb|gltf)$/.test(file)).sort();
  return found.map((file) => path.join(SCENES, name, file));
}

test('real scenes have the same bytes', { skip: shared }, async (t) => {
  const scenes = scenesIn('real').filter((_, n) => EVERY || n % 8 === 0);
  for (const scene of scenes)
    for (const threads of ['1', '4'])
      await t.test(`${path.relative(SCENES, scene)}, ${threads}`, () => both(['bake', scene, '-o', 'out.vxs', '--resolution', '512', '--quiet', '--threads', threads]));
});

test('malformed scenes have the same messages and exit statuses', { skip: shared }, async (t) => {
  const scenes = scenesIn('malformed').filter((_, n) => EVERY || n % 16 === 0);
  for (const scene of scenes)
    await t.test(path.relative(SCENES, scene), () => both(['bake', scene, '-o', 'out.vxs', '--resolution', '64', '--quiet']));
});
