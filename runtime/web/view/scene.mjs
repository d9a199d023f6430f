// Reads the scene of a level with three.js, from bytes alone: nothing is loaded from outside of the page.
// SPDX-License-Identifier: MIT
import { LoadingManager } from 'three';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import basisScript from 'packed:three/examples/jsm/libs/basis/basis_transcoder.js';
import basisWasm from 'packed:three/examples/jsm/libs/basis/basis_transcoder.wasm';
import dracoScript from 'packed:three/examples/jsm/libs/draco/gltf/draco_wasm_wrapper.js';
import dracoWasm from 'packed:three/examples/jsm/libs/draco/gltf/draco_decoder.wasm';
import { LevelError, filesBeside, gltfJson } from './level.mjs';
import { unpack } from './unpack.mjs';

const DECODERS = {
  KHR_draco_mesh_compression: { 'draco_wasm_wrapper.js': dracoScript, 'draco_decoder.wasm': dracoWasm },
  KHR_texture_basisu: { 'basis_transcoder.js': basisScript, 'basis_transcoder.wasm': basisWasm },
};
const WHITE =
  'data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR42mP4DwABAQEAHLCMmQAAAABJRU5ErkJggg==';

/** Addresses of bytes, for loaders of three.js. */
class Addresses {
  #urls = new Map();

  add(name, bytes) {
    this.#urls.set(name, URL.createObjectURL(new Blob([bytes])));
  }
  get(name) {
    return this.#urls.get(name);
  }
  free() {
    for (const url of this.#urls.values()) URL.revokeObjectURL(url);
  }
}

function indexOfScene(json, choice, baked) {
  const scenes = json.scenes ?? [],
    named = (name) => scenes.findIndex((scene) => scene.name === name);
  if (choice !== null && choice !== undefined) {
    const index = named(choice) >= 0 ? named(choice) : Number(choice);
    if (!scenes[index]) throw new LevelError(`The file has no scene '${choice}'.`);
    return index;
  }
  return baked && named(baked) >= 0 ? named(baked) : (json.scene ?? 0);
}

/**
 * The glTF scene of a level.
 * baked  name of the scene that was baked; null: not known
 * Returns { gltf, root, missing: [URI] }: root is an Object3D, missing are images that are not there.
 */
export async function readScene(level, renderer, baked) {
  const { name, bytes, choice } = level.scene,
    json = gltfJson(bytes, name),
    urls = new Addresses(),
    missing = [];
  for (const { uri, kind } of filesBeside(json)) {
    const data = level.files.get(uri);
    if (data) urls.add(uri, data);
    else if (kind === 'buffer') throw new LevelError(`${name} needs the file ${uri}, and it is not here.`);
    else if (kind === 'image') missing.push(uri);
  }
  for (const [extension, files] of Object.entries(DECODERS))
    if (json.extensionsUsed?.includes(extension))
      for (const [file, packed] of Object.entries(files)) urls.add(`decoders/${file}`, await unpack(packed));

  const manager = new LoadingManager();
  manager.setURLModifier((url) => (/^(blob|data):/i.test(url) ? url : (urls.get(url) ?? WHITE)));
  const draco = new DRACOLoader(manager).setDecoderPath('decoders/');
  const basis = new KTX2Loader(manager).setTranscoderPath('decoders/').detectSupport(renderer);
  const loader = new GLTFLoader(manager)
    .setDRACOLoader(draco)
    .setKTX2Loader(basis)
    .setMeshoptDecoder(MeshoptDecoder);
  try {
    const whole = bytes.byteLength === bytes.buffer.byteLength; // else a part, which is copied
    const gltf = await loader.parseAsync(whole ? bytes.buffer : bytes.slice().buffer, '');
    const root = gltf.scenes[indexOfScene(json, choice, baked)] ?? gltf.scene;
    if (!root) throw new LevelError(`${name} has no scene.`);
    return { gltf, root, missing: [...new Set(missing)] };
  } catch (error) {
    throw error instanceof LevelError ? error : new LevelError(`${name} cannot be shown: ${error.message}`);
  } finally {
    draco.dispose();
    basis.dispose();
    urls.free();
  }
}
