// Shadows inside glTF files: through glTF-Transform, into three.js.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { RELEASES, launch, noBrowser, openPage, run, serve } from './browser.mjs';
import { pillars } from './small_scene.mjs';

const PACKAGE = process.env.VXS_PACKAGE ?? new URL('../../build/web/vxs', import.meta.url).pathname;
const VXS = process.env.VXS ?? new URL('../../build/release/vxs', import.meta.url).pathname;
const libraries = createRequire(path.join(PACKAGE, 'x.mjs'));
const has = (name) => {
  try {
    return libraries.resolve(name);
  } catch {
    return null;
  }
};
const skip = !has('@gltf-transform/core') ? '@gltf-transform/core is not installed: make web' : !fs.existsSync(VXS) && `no command at ${VXS}: make`;
const library = async (name) => import(pathToFileURL(has(name)));
let folder, core, ours;
const at = (name) => path.join(folder, name);

before(async () => {
  if (skip) return;
  folder = fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-gltf-'));
  fs.writeFileSync(at('level.glb'), pillars());
  fs.writeFileSync(at('named.glb'), pillars((json) => { json.extras = { vxs_shadows: 'level.vxs' }; }));
  fs.writeFileSync(at('of_scene.glb'), pillars((json) => { json.scenes[0].extras = { vxs_shadows: 'level.vxs' }; }));
  const extended = (value) => (json) => {
    json.extensions.VXS_baked_shadows = value;
    json.extensionsUsed.push('VXS_baked_shadows');
  };
  fs.writeFileSync(at('linked.glb'), pillars(extended({ uri: 'level.vxs' })));
  fs.writeFileSync(at('wrong.glb'), pillars(extended({ bufferView: 0 })));
  execFileSync(VXS, ['bake', 'level.glb', '-o', 'level.vxs', '--resolution', '256', '--quiet'], { cwd: folder });
  fs.writeFileSync(at('inside.glb'), pillars(extended({ bufferView: 2 }), fs.readFileSync(at('level.vxs'))));
  core = await library('@gltf-transform/core');
  ours = await import(pathToFileURL(path.join(PACKAGE, 'three/gltf-transform.mjs')));
});
after(() => folder && fs.rmSync(folder, { recursive: true }));

const newIO = () => new core.NodeIO().setLogger(new core.Logger(core.Logger.Verbosity.SILENT)).registerExtensions([ours.VXSBakedShadows]);

/** level.glb with its shadows inside. */
async function embedded() {
  const io = newIO(), document = await io.read(at('level.glb')), bytes = fs.readFileSync(at('level.vxs'));
  ours.embedShadows(document, bytes);
  return { io, document, bytes };
}

test('bytes stay the same through GLB, and JSON with files', { skip }, async () => {
  const { io, document, bytes } = await embedded();
  const again = await io.readBinary(await io.writeBinary(document));
  assert.deepEqual(Buffer.from(ours.shadowsOf(again)), bytes);
  await io.write(at('apart.gltf'), again);
  const json = JSON.parse(fs.readFileSync(at('apart.gltf')));
  assert.ok(json.extensionsUsed.includes('VXS_baked_shadows') && !json.extensionsRequired?.includes('VXS_baked_shadows'));
  assert.equal(json.bufferViews[json.extensions.VXS_baked_shadows.bufferView].byteLength, bytes.length);
  assert.deepEqual(Buffer.from(ours.shadowsOf(await io.read(at('apart.gltf')))), bytes);
  assert.deepEqual(Buffer.from(ours.shadowsOf(await io.read(at('inside.glb')))), bytes);
  const without = await new core.NodeIO().readBinary(await io.writeBinary(document));
  assert.equal(ours.shadowsOf(without), null);
  assert.equal(ours.shadowsOf(await io.read(at('level.glb'))), null);
});

test('a URI stays', { skip }, async () => {
  const io = newIO(), document = await io.read(at('linked.glb')), shadows = document.getRoot().getExtension('VXS_baked_shadows');
  assert.equal(shadows.getURI(), 'level.vxs');
  const json = (await io.writeJSON(await io.readBinary(await io.writeBinary(document)))).json;
  assert.deepEqual(json.extensions.VXS_baked_shadows, { uri: 'level.vxs' });
});

const functions = skip || !has('@gltf-transform/functions') && '@gltf-transform/functions is not installed beside @gltf-transform/core';
test('prune, dedup, weld and quantize keep the bytes', { skip: functions }, async () => {
  const { io, document, bytes } = await embedded(), { dedup, prune, quantize, weld } = await library('@gltf-transform/functions');
  await document.transform(dedup(), prune(), weld(), quantize());
  assert.deepEqual(Buffer.from(ours.shadowsOf(await io.readBinary(await io.writeBinary(document)))), bytes);
});

test('what is written follows the schema', { skip }, async () => {
  const { io, document } = await embedded(), schema = path.join(PACKAGE, 'three/VXS_baked_shadows.schema.json');
  const script = 'import json, jsonschema, sys; jsonschema.validate(json.loads(sys.argv[1]), json.load(open(sys.argv[2])))';
  const valid = (value) => execFileSync('/usr/bin/python3', ['-c', script, JSON.stringify(value), schema], { stdio: 'pipe' });
  valid((await io.writeJSON(document)).json.extensions.VXS_baked_shadows);
  valid({ uri: 'level.vxs' });
  for (const wrong of [{}, { bufferView: -1 }, { bufferView: 0, uri: 'level.vxs' }, { uri: '' }, { file: 'level.vxs' }]) assert.throws(() => valid(wrong), JSON.stringify(wrong));
});

test('GLTFLoader finds shadows inside and beside a file', { skip: skip || noBrowser }, async () => {
  const server = await serve(folder), browser = await launch();
  try {
    for (const three of RELEASES) {
      const page = await openPage(browser, server, { three });
      for (const file of ['inside', 'named', 'of_scene', 'linked'])
        assert.deepEqual(await run(page, '/tests/three_page.mjs', 'fromGltf', `/files/${file}.glb`), { lights: 3, matched: 3 }, file);
      assert.deepEqual(await run(page, '/tests/three_page.mjs', 'fromGltf', '/files/level.glb'), { lights: null });
      await assert.rejects(run(page, '/tests/three_page.mjs', 'fromGltf', '/files/wrong.glb'), /VXSError|not a .vxs file/);
      assert.deepEqual(page.faults, []);
    }
  } finally {
    await browser.close();
    await server.close();
  }
});
