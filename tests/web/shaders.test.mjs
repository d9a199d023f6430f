// vxs/shaders: for a shader compiler each text is the header itself.
// SPDX-License-Identifier: GPL-3.0-or-later
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { test } from 'node:test';
import { pathToFileURL } from 'node:url';

const ROOT = new URL('../../', import.meta.url).pathname, PACKAGE = process.env.VXS_PACKAGE ?? path.join(ROOT, 'build/web/vxs');
const ORDER = ['vxs_tables', 'vxs_lookup', 'vxs_lookup_blocks', 'vxs_space', 'vxs_depths', 'vxs_intervals', 'vxs_smoke', 'vxs_air_light', 'vxs_air_ray', 'vxs_air', 'vxs_air_path', 'vxs_fog'];
const skip = spawnSync('cpp', ['--version']).error ? 'no preprocessor: cpp' : false;

const tokens = (texts, defines) => spawnSync('cpp', ['-undef', '-P', ...defines], { input: texts.join('\n'), encoding: 'utf8' }).stdout.split(/\s+/);
const OTHERS = { vxs_tables: 'runtime/gl/tables.glsl', vxs_fog: 'runtime/web/three/fog.glsl' };
const header = (name) => [OTHERS[name], `formats/${name}.h`, `runtime/volumes/${name}.h`].map((file) => path.join(ROOT, file ?? '')).find((file) => fs.statSync(file, { throwIfNoEntry: false })?.isFile());

test('texts have the tokens of the headers', { skip }, async () => {
  const module = await import(pathToFileURL(path.join(PACKAGE, 'runtime/shaders.mjs')));
  assert.deepEqual(Object.keys(module).sort(), [...ORDER].sort());
  const headers = ORDER.map((name) => fs.readFileSync(header(name), 'utf8').replace(/^#include.*$/gm, ''));
  for (const defines of [['-DGL_ES=1', '-D__VERSION__=300'], ['-D__VERSION__=430'], ['-DVXS_HLSL']]) {
    const all = ['-DVXS_GL_TABLES', '-Dvxs_word(a,i)=W(a,i)', '-U__STDC__', ...defines], wanted = tokens(headers, all);
    assert.ok(wanted.length > 10000);
    assert.deepEqual(tokens(ORDER.map((name) => module[name]), all), wanted, defines.join(' '));
  }
});
