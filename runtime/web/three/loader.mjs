// Loading a .vxs file, and lighting a scene of three.js with it.
// SPDX-License-Identifier: MIT
import { Box3, FileLoader, Loader, Matrix4, Vector3 } from 'three';
import { VXSError, load } from 'vxs';
import { matchLights } from './names.mjs';
import { filterOf, fromRootMatrix, streamTexture, tablesTexture, wordsTexture } from './words.mjs';

const MOST_LEVELS = 14; // of lights with tables, which take 2 s to make at 14
let standard; // the runtime that all loaders share, loaded at the first use

/** Loads .vxs files as BakedShadows. Errors are VXSErrors where the bytes are wrong, else those of FileLoader. */
export class ShadowLoader extends Loader {
  #runtime;

  /** Use this runtime, or a promise of one, from load() of 'vxs', 'vxs/inline' or 'vxs/core'. */
  setRuntime(runtime) {
    this.#runtime = runtime;
    return this;
  }

  load(url, onLoad, onProgress, onError) {
    const file = new FileLoader(this.manager).setPath(this.path).setResponseType('arraybuffer')
      .setRequestHeader(this.requestHeader).setWithCredentials(this.withCredentials);
    const failed = (error) => {
      (onError ?? console.error)(error);
      this.manager.itemError(url);
    };
    file.load(url, (bytes) => {
      this.manager.itemStart(url); // until it is parsed, too
      this.parseAsync(bytes).then(onLoad, failed).finally(() => this.manager.itemEnd(url));
    }, onProgress, onError);
  }

  /** bytes  Uint8Array or ArrayBuffer */
  parse(bytes, onLoad, onError = console.error) {
    this.parseAsync(bytes).then(onLoad, onError);
  }

  async parseAsync(bytes) {
    const runtime = await (this.#runtime ?? (standard ??= load()));
    return new BakedShadows(runtime.open(bytes), this.constructor.ways);
  }

  /** Shadows of a file that is read by ranges, as StreamedShadows. options: those of stream() of 'vxs'. */
  async streamAsync(url, options) {
    const runtime = await (this.#runtime ?? (standard ??= load()));
    return new StreamedShadows(await runtime.stream(url, options), { lookup: this.constructor.ways.lookup });
  }
}

const meshesOf = (root, act) => root.traverse((object) => object.isMesh && act(object));

/** The shadows of a file, attached to the lights of one scene at a time. */
export class BakedShadows {
  #way = null;
  #words = null;
  #tables = new Map();
  #restore = [];

  #ways;

  /** ways  { name: class }: how lights may shine with a baked shadow */
  constructor(asset, ways) {
    this.asset = asset;
    this.pairs = [];
    this.#ways = ways;
  }

  get lights() { return this.asset.lights; }

  /** The words of all lights as a texture, which the passes of this file share: { texture, wide, first }. */
  get words() { return (this.#words ??= this.newWords()); }
  newWords() { return wordsTexture(this.lights); }

  /** Tables of a light, as `words`, made at the first use; null: it has none. */
  tables(baked) {
    if (baked.coding !== 'blocks' || baked.levels > MOST_LEVELS) return null;
    if (!this.#tables.has(baked)) this.#tables.set(baked, tablesTexture(baked));
    return this.#tables.get(baked);
  }

  /**
   * Let lights below `target` shine with their baked shadows. index.d.ts describes the options. Nothing is changed if it throws.
   * Returns what matched: { matched, lights, baked }.
   */
  attach(target, { way = 'lookup', filter, renderer, movers = [], ...options } = {}) {
    const root = target.scene ?? target;
    const Way = this.#ways[way];
    if (!Way) throw new VXSError('argument', `way is '${way}': expected ${Object.keys(this.#ways).join(' or ')}`);
    root.updateWorldMatrix(true, true);
    const fromRoot = fromRootMatrix(root), match = matchLights(this.lights, root, fromRoot, target.parser ? target : null);
    const kernel = filterOf(filter);
    if (this.#way) this.detach();
    if (!match.matched.length) return match;
    this.#way = new Way(match.matched, { shadows: this, kernel, renderer, fromRoot, movers, ...options });
    try {
      this.#receive(root, movers);
      if (movers.length && this.#way.live) this.#fit(root);
      if (movers.length && renderer) renderer.shadowMap.enabled = true;
    } catch (error) {
      this.detach();
      throw error;
    }
    this.pairs = match.matched;
    this.fromRoot = fromRoot;
    return match;
  }

  // All that is lit receives shadows. With movers, they alone cast into live maps: what is baked would be in shadow twice.
  #receive(root, movers) {
    const set = (object, name, value) => {
      const had = object[name];
      if (had === value) return;
      object[name] = value;
      this.#restore.push(() => { object[name] = had; });
    };
    const moves = new Set();
    for (const mover of movers) meshesOf(mover, (mesh) => moves.add(mesh));
    const shade = (mesh) => {
      set(mesh, 'receiveShadow', true);
      if (moves.size) set(mesh, 'castShadow', moves.has(mesh));
      this.#way.add(mesh);
    };
    meshesOf(root, shade);
    moves.forEach(shade);
    if (this.#way.live) for (const light of this.#way.baked.keys()) set(light, 'castShadow', this.#way.live === 'always' || movers.length > 0);
  }

  // Live maps show what moves, anywhere in the volume that is baked: where the shadow camera of a sun is as three.js makes it.
  #fit(root) {
    const volume = new Box3(), corner = new Vector3();
    for (const [light, baked] of this.#way.baked) {
      const { camera } = light.shadow;
      if (baked.kind !== 'directional' || camera.right !== 5 || camera.top !== 5 || camera.left !== -5 || camera.bottom !== -5) continue;
      const { near, far } = camera, side = baked.resolution;
      light.shadow.updateMatrices(light);
      const toCamera = new Matrix4().set(...baked.matrix, 0, 0, 0, 1).invert().premultiply(root.matrixWorld).premultiply(camera.matrixWorldInverse);
      volume.makeEmpty();
      for (let n = 0; n < 8; n++) volume.expandByPoint(corner.set(n & 1, (n >> 1) & 1, n >> 2).multiplyScalar(side).applyMatrix4(toCamera));
      const { min, max } = volume;
      Object.assign(camera, { left: min.x, right: max.x, bottom: min.y, top: max.y, near: -max.z, far: -min.z }).updateProjectionMatrix();
      this.#restore.push(() => Object.assign(camera, { left: -5, right: 5, bottom: -5, top: 5, near, far }).updateProjectionMatrix());
    }
  }

  /** Shade more meshes, below `object`, which came after attach(). */
  add(object) {
    meshesOf(object, (mesh) => {
      mesh.receiveShadow = true;
      this.#way?.add(mesh);
    });
  }

  /** { box: K } or { smooth: K }: exact filters of the way 'lookup'. */
  setFilter(filter) {
    this.#way?.setFilter(filterOf(filter));
  }

  /** Undo attach(). */
  detach() {
    this.#way?.dispose();
    this.#way = null;
    this.#restore.splice(0).reverse().forEach((undo) => undo());
    this.pairs = [];
  }

  /** Free textures and the file. */
  dispose() {
    this.detach();
    this.#words?.texture.dispose();
    this.#words = null;
    this.#tables.forEach(({ texture }) => texture.dispose());
    this.#tables.clear();
    this.asset.dispose();
  }
}

/** Shadows whose words come while they are shown: call frame() each frame. */
export class StreamedShadows extends BakedShadows {
  newWords() {
    this.asset.changes(); // the texture begins with all that is there
    return streamTexture(this.asset);
  }

  tables() { return null; } // they are made of whole lights

  /** As frame() of a stream. */
  frame(foci) {
    const status = this.asset.frame(foci);
    this.words.update(this.asset.changes());
    return status;
  }
}
