// The package as a user installs it: from the tarball of `npm pack`, into an empty folder, without compilers.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import { test } from 'node:test';

const PACKAGE = process.env.VXS_PACKAGE;
const read = (file) => JSON.parse(fs.readFileSync(file, 'utf8'));

test('every file that the package names is in it, and nothing else', () => {
  const manifest = read(path.join(PACKAGE, 'package.json'));
  const [packed] = JSON.parse(execFileSync('npm', ['pack', '--dry-run', '--json'], { cwd: PACKAGE, encoding: 'utf8' }));
  const held = new Set(packed.files.map((file) => `./${file.path}`));
  const filesOf = (to) => (typeof to === 'string' ? [to] : Object.values(to).flatMap(filesOf));
  const named = filesOf(manifest.exports);
  for (const file of [...named, ...Object.values(manifest.bin).map((bin) => `./${bin}`)]) assert.ok(held.has(file), file);
  for (const file of held) assert.match(file, /^\.\/(bin|runtime|baker|three)\/|^\.\/(package\.json|README\.md|LICENSE\.(MIT|GPL-3\.0)|view\.html)$/);
});

test('the package has the version of the project', () => {
  const header = fs.readFileSync(new URL('../../runtime/vxs.h', import.meta.url), 'utf8');
  const part = (name) => header.match(new RegExp(`VXS_VERSION_${name} (\\d+)`))[1];
  assert.equal(read(path.join(PACKAGE, 'package.json')).version, ['MAJOR', 'MINOR', 'PATCH'].map(part).join('.'));
});

test('it installs into an empty folder without a network, and runs there without compilers', () => {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'a user\'s folder '));
  // the folder of node alone: no emcc, no make, no vxs
  const env = { HOME: folder, PATH: [path.dirname(process.execPath), '/bin'].join(path.delimiter) };
  const run = (...command) => execFileSync(command[0], command.slice(1), { cwd: folder, env, encoding: 'utf8' });
  try {
    const [packed] = JSON.parse(execFileSync('npm', ['pack', PACKAGE, '--json', '--pack-destination', folder], { encoding: 'utf8' }));
    fs.writeFileSync(path.join(folder, 'package.json'), '{ "private": true }');
    run('npm', 'install', '--offline', '--no-audit', '--no-fund', `./${packed.filename}`);
    execFileSync(process.env.VXS, ['scene', 'city', '-o', path.join(folder, 'level.glb'), '--triangles', '1000']);
    run('npx', '--offline', 'vxs', 'bake', 'level.glb', '-o', 'level.vxs', '--resolution', '256', '--quiet');
    assert.match(run('npx', '--offline', 'vxs', 'info', 'level.vxs'), /256/);
    const look = "const asset = vxs.open(require('fs').readFileSync('level.vxs')); console.log(asset.lights.length); asset.dispose();";
    const load = `async function main(load) { const vxs = await load(); ${look} }`;
    assert.equal(run('node', '-e', `${load} main(require('vxs').load);`), '1\n');
    assert.equal(run('node', '-e', `${load} import('vxs').then((module) => main(module.load));`), '1\n');
    assert.equal(run('node', '-e', `${load} import('vxs/inline').then((module) => main(module.load));`), '1\n');
  } finally {
    fs.rmSync(folder, { recursive: true });
  }
});
