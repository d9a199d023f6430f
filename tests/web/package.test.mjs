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
  const named = Object.values(manifest.exports).flatMap((to) => (typeof to === 'string' ? [to] : Object.values(to)));
  for (const file of [...named, ...Object.values(manifest.bin).map((bin) => `./${bin}`)]) assert.ok(held.has(file), file);
  for (const file of held) assert.match(file, /^\.\/(bin|runtime|baker|three)\/|^\.\/(package\.json|README\.md|LICENSE\.(MIT|GPL-3\.0)|view\.html)$/);
});

test('the package has the version of the project', () => {
  const header = fs.readFileSync(new URL('../../runtime/vxs.h', import.meta.url), 'utf8');
  const part = (name) => header.match(new RegExp(`VXS_VERSION_${name} (\\d+)`))[1];
  assert.equal(read(path.join(PACKAGE, 'package.json')).version, ['MAJOR', 'MINOR', 'PATCH'].map(part).join('.'));
});
