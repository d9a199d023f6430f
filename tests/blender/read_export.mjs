// node read_export.mjs FILE: loads a glTF file and the shadows that it names, as a page does; prints which lights match.
// SPDX-License-Identifier: GPL-3.0-or-later
import { readFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { VXSLoader, VXSShadowsPlugin } from 'vxs/three';

globalThis.ProgressEvent ??= class extends Event {}; // which the loaders of three.js send

class DiskLoader extends VXSLoader { // Node's fetch reads no files
  async loadAsync(url) { return this.parseAsync(await readFile(decodeURIComponent(url))); }
}

const file = process.argv[2], folder = dirname(file);
let bytes = await readFile(file);
if (file.endsWith('.gltf')) {
  const json = JSON.parse(bytes);
  for (const buffer of json.buffers) {
    const data = await readFile(join(folder, decodeURIComponent(buffer.uri)));
    buffer.uri = `data:application/octet-stream;base64,${data.toString('base64')}`;
  }
  bytes = Buffer.from(JSON.stringify(json));
}
const loader = new GLTFLoader();
loader.register((parser) => new VXSShadowsPlugin(parser, new DiskLoader()));
const gltf = await loader.parseAsync(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength), `${folder}/`);
const { matched, lights, baked } = gltf.shadows.attach(gltf);
console.log(JSON.stringify({ matched: matched.map((m) => [m.baked.name, m.moved]), lights: lights.length, baked: baked.length }));
