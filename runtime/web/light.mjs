// SPDX-License-Identifier: MIT
// Files in memory and their lights: description, words and constants for shaders, depth maps. lookups.mjs adds lookups.
import { VXSError, bytesOf } from './instance.mjs';

const KINDS = ['', 'directional', 'spot', 'point'];
const CODINGS = ['', 'dag', 'blocks'];
const WHICH = { centre: 0, least: 1, greatest: 2 };
const CONSTANTS_BYTES = 96;

/** Coordinates of [x, y, z] or { x, y, z }; they may be NaN or infinite: such a point is outside. */
export function vector(v, what) {
  const x = v?.x ?? v?.[0], y = v?.y ?? v?.[1], z = v?.z ?? v?.[2];
  if (typeof x !== 'number' || typeof y !== 'number' || typeof z !== 'number') {
    throw new TypeError(`${what} must be three numbers: [x, y, z] or { x, y, z }`);
  }
  return [x, y, z];
}

export function integer(value, least, most, what) {
  if (!Number.isInteger(value) || value < least || value > most) {
    throw new RangeError(`${what} is ${value}: expected an integer from ${least} to ${most}`);
  }
  return value;
}

/** An object with memory of the instance. */
export class Owner {
  #close; #net; #handle;

  /** close(handle) must not refer to this object, or `net`, a FinalizationRegistry, would never see it unused. */
  constructor(heap, handle, close, net) {
    this.#handle = handle;
    this.#close = close;
    this.#net = net;
    net?.register(this, [close, handle], this);
    Object.defineProperty(this, 'heap', { value: heap });
  }

  get handle() {
    if (!this.#handle) throw new VXSError('disposed', 'used after dispose()');
    return this.#handle;
  }

  get disposed() { return !this.#handle; }

  dispose() {
    const handle = this.#handle;
    if (!handle) return;
    this.#handle = 0;
    this.#net?.unregister(this);
    this.#close(handle);
  }
}

export const newNet = () => (typeof FinalizationRegistry === 'function'
  ? new FinalizationRegistry(([close, handle]) => close(handle)) : undefined);

/** An open file, in memory or as a stream. `calls` are functions of C: lightCount(handle), light(handle, n), metadata(handle). */
export class Opened extends Owner {
  #metadata; #info;

  constructor(heap, handle, close, net, calls, Light) {
    super(heap, handle, close, net);
    this.#metadata = calls.metadata;
    const lights = Array.from({ length: calls.lightCount(handle) }, (_, n) => new Light(this, calls.light(handle, n) >>> 0, n));
    Object.defineProperty(this, 'lights', { value: Object.freeze(lights), enumerable: true });
  }

  /** The light of an index or a name. */
  light(which) {
    const { lights } = this, light = typeof which === 'number' ? lights[which] : lights.find((l) => l.name === which);
    if (!light) throw new RangeError(`no light ${JSON.stringify(which)}; there are: ${lights.map((l) => l.name).join(', ')}`);
    return light;
  }

  get info() {
    const { heap, handle } = this;
    if (this.#info === undefined) {
      const text = this.#metadata(handle);
      this.#info = text ? JSON.parse(heap.text(text)) : null;
    }
    return this.#info;
  }
}

export class CoreLight {
  #owner; #at;

  constructor(owner, at, index) {
    this.#owner = owner;
    this.#at = at;
    const { heap } = owner, { c } = heap, out = heap.scratch;
    this.index = index;
    this.name = heap.text(c.web_describe(at, out));
    const [kind, coding, levels, maps, bounded, packing, wordCount, texel, voxel, near, range, cosOuter, dx, dy, dz, ...matrix] =
      heap.f64.subarray(out / 8, out / 8 + 27);
    Object.assign(this, {
      kind: KINDS[kind], coding: CODINGS[coding], packing: packing === 1 ? 'fast' : 'small',
      levels, resolution: 2 ** levels, maps, bounded: !!bounded, wordCount,
      texelMetres: texel, voxelMetres: voxel, nearMetres: near, rangeMetres: range, cosOuter,
      direction: [dx, dy, dz], matrix: Float64Array.from(matrix),
    });
  }

  /** The light in C; throws if its file has been disposed of. */
  get at() { return this.#owner.handle && this.#at; }
  get owner() { return this.#owner; }

  words() {
    const { at } = this, { heap } = this.#owner, first = heap.c.web_words(at) >>> 2;
    return heap.u32.slice(first, first + this.wordCount);
  }

  constants(origin = [0, 0, 0], firstWord = this.firstWord ?? 0) {
    const { at } = this, { heap } = this.#owner, out = heap.scratch;
    heap.c.web_constants(at, ...vector(origin, 'origin'), integer(firstWord, 0, 2 ** 32 - 1, 'firstWord'), out);
    return heap.u8.slice(out, out + CONSTANTS_BYTES);
  }

  depthMap({ map = 0, resolution, shift, which = 'centre', voxels = false, x = 0, y = 0, width, height } = {}) {
    const { at, levels } = this, { heap } = this.#owner;
    integer(map, 0, this.maps - 1, 'map');
    if (!Object.hasOwn(WHICH, which)) throw new RangeError(`which is ${which}: expected centre, least or greatest`);
    if (resolution !== undefined) {
      const power = Math.log2(integer(resolution, 1, this.resolution, 'resolution'));
      if (!Number.isInteger(power)) throw new RangeError(`resolution is ${resolution}: expected a power of two`);
      if (shift !== undefined) throw new TypeError('resolution and shift exclude each other');
      shift = levels - power;
    }
    integer(shift ??= 0, 0, levels, 'shift');
    const side = 2 ** (levels - shift), far = 2 ** 30 / 2 ** shift;
    integer(x, -far, far, 'x');
    integer(y, -far, far, 'y');
    integer(width ??= side, 0, far - Math.max(x, 0), 'width');
    integer(height ??= side, 0, far - Math.max(y, 0), 'height');

    // strips of rows, so that the memory of the instance does not grow by a whole map
    const data = new (voxels ? Uint32Array : Float32Array)(width * height);
    const rows = Math.min(height, Math.max(1, Math.floor(2 ** 18 / Math.max(width, 1))));
    const out = heap.take(4 * width * rows);
    try {
      for (let row = 0; row < height; row += rows) {
        const count = Math.min(rows, height - row);
        heap.c.web_depth_map(at, map, x * 2 ** shift, (y + row) * 2 ** shift, width, count, shift, WHICH[which], +voxels, out);
        const from = (voxels ? heap.u32 : heap.f32).subarray(out / 4, out / 4 + width * count);
        data.set(from, row * width);
      }
    } finally {
      heap.free(out);
    }
    return { width, height, data };
  }
}

export class CoreAsset extends Opened {
  constructor(heap, handle, net, Light) {
    const { web_close: close, web_light_count: lightCount, web_light: light, web_metadata: metadata } = heap.c;
    super(heap, handle, close, net, { lightCount, light, metadata }, Light);
  }
}

/** Opens bytes with the asset and light classes of a build. */
export function openWith(heap, net, Asset, Light, data, { memoryLimit = 0 } = {}) {
  const bytes = bytesOf(data);
  if (typeof memoryLimit !== 'number' || !(memoryLimit >= 0 && memoryLimit <= 2 ** 53)) {
    throw new RangeError(`memoryLimit is ${memoryLimit}: expected bytes, 0 or more`);
  }
  const at = heap.put(bytes);
  try {
    const handle = heap.c.web_open(at, bytes.byteLength, memoryLimit, heap.scratch) >>> 0;
    if (!handle) throw heap.error(heap.scratch);
    return new Asset(heap, handle, net, Light);
  } finally {
    heap.free(at);
  }
}

