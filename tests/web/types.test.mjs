// The types of the package: what a user may write, types.mts, by the compiler of TypeScript; and that they name all that modules export.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { fileURLToPath } from 'node:url';

import { PACKAGE, folder, runtime } from './native.mjs';

const TSC = path.join(PACKAGE, '../node_modules/typescript/bin/tsc');
const FLAGS = ['--noEmit', '--strict', '--target', 'es2022', '--lib', 'es2022,dom'];

test('a user may write types.mts, and with require() a part of it', { skip: !fs.existsSync(TSC) && 'no TypeScript' }, () => {
  fs.mkdirSync(path.join(folder, 'node_modules'));
  fs.symlinkSync(PACKAGE, path.join(folder, 'node_modules/vxs'), 'junction');
  fs.copyFileSync(fileURLToPath(new URL('types.mts', import.meta.url)), path.join(folder, 'types.mts'));
  fs.writeFileSync(path.join(folder, 'types_require.cts'), "import vxs = require('vxs');\nexport const light = async (b: ArrayBuffer) => " +
    "(await vxs.load()).open(b).light('sun').lookup([0, 1, 2]).toFixed();\n");
  for (const [module, resolution] of [['node16', 'node16'], ['esnext', 'bundler']]) {
    const files = module === 'node16' ? ['types.mts', 'types_require.cts'] : ['types.mts'];
    const done = spawnSync(process.execPath, [TSC, ...FLAGS, '--module', module, '--moduleResolution', resolution, ...files],
      { cwd: folder, encoding: 'utf8' });
    assert.equal(done.status, 0, done.stdout);
  }
});

test('each module exports what its types name', async () => {
  const named = (types) => [...fs.readFileSync(path.join(PACKAGE, 'runtime', types), 'utf8')
    .matchAll(/^export (?:const|function|class|\{) ?(\w+)/gm)].map((m) => m[1]).sort();
  for (const [module, types] of [['vxs', 'vxs'], ['vxs-inline', 'vxs'], ['core', 'core'], ['shaders', 'shaders']]) {
    assert.deepEqual(Object.keys(await runtime(`${module}.mjs`)).sort(), named(`${types}.d.ts`), module);
  }
});
