// Makes the page of vxs view, one file: bundle.mjs OUT.html, with NODE_PATH at node_modules and VXS_PACKAGE at the package.
// SPDX-License-Identifier: MIT
import { createRequire } from 'node:module';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import zlib from 'node:zlib';

const here = path.dirname(fileURLToPath(import.meta.url)),
  out = process.argv[2];
const vxs = process.env.VXS_PACKAGE,
  modules = process.env.NODE_PATH;
const { build } = createRequire(path.join(modules, 'x.js'))('esbuild');

/** `packed:FILE` is the file's base64 of gzip. */
const packed = {
  name: 'packed',
  setup(on) {
    on.onResolve({ filter: /^packed:/ }, ({ path: name }) => {
      const file = name.slice('packed:'.length);
      return {
        namespace: 'packed',
        path: file.startsWith('vxs/') ? path.join(vxs, file.slice(4)) : path.join(modules, file),
      };
    });
    on.onLoad({ filter: /./, namespace: 'packed' }, ({ path: file }) => ({
      contents: zlib.gzipSync(fs.readFileSync(file), { level: 9 }).toString('base64'),
      loader: 'text',
    }));
  },
};

/** Texts of shaders without indentation and blanks in rows. */
const shaders = {
  name: 'shaders',
  setup(on) {
    on.onLoad({ filter: /[\\/]shaders\.mjs$/ }, ({ path: file }) => ({
      contents: fs
        .readFileSync(file, 'utf8')
        .replace(/(\\n) +/g, '$1')
        .replace(/ {2,}/g, ' '),
      loader: 'js',
    }));
  },
};

const options = {
  bundle: true,
  minify: true,
  write: false,
  legalComments: 'eof',
  logLevel: 'warning',
  charset: 'utf8',
};
const script = await build({
  ...options,
  entryPoints: [path.join(here, 'main.mjs')],
  format: 'iife',
  target: 'es2022',
  nodePaths: [modules],
  plugins: [packed, shaders],
  alias: {
    vxs: path.join(vxs, 'runtime/vxs.mjs'),
    'vxs/three': path.join(vxs, 'three/index.mjs'),
    'vxs/shaders': path.join(vxs, 'runtime/shaders.mjs'),
  },
  define: { 'import.meta.url': '"file:///"' }, // loaders of three.js make addresses of it, which are not used
});
const style = await build({ ...options, entryPoints: [path.join(here, 'view.css')] });

const text = fs
  .readFileSync(path.join(here, 'page.html'), 'utf8')
  .replace('/*style*/', () => style.outputFiles[0].text.trim())
  .replace('/*script*/', () => script.outputFiles[0].text.trim());
if (/\/\*(style|script)\*\//.test(text))
  throw new Error('page.html: a place for the style or the script is missing, or there twice');
fs.writeFileSync(out, text);
