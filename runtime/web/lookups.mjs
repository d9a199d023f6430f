// SPDX-License-Identifier: MIT
// Lights with lookups, and files with points and smoke.
import { CoreAsset, CoreLight, integer, vector } from './light.mjs';

const STATES = ['lit', 'shadow', 'outside'];
const NO_NORMAL = [0, 0, 0], NO_OPTIONS = {}, ONE_TEXEL = [1, 0];
const CHUNK = 1024; // points of one call
const INTERVALS = 256, INTERVAL_BYTES = 24;
const FILTER_MAX = 17;

/** [width, is smooth] of 9, { box: 9 } or { smooth: 9 }. */
function filterOf(filter) {
  if (filter === undefined) return ONE_TEXEL;
  if (filter?.smooth !== undefined) return [integer(filter.smooth, 1, FILTER_MAX, 'filter.smooth'), 1];
  const width = integer(filter?.box ?? filter, 1, FILTER_MAX, 'filter');
  if (width % 2 === 0) throw new RangeError(`filter is ${width}: a box has an odd width; { smooth: ${width} } may be even`);
  return [width, 0];
}

const normalOf = (normal) => (normal ? vector(normal, 'normal') : NO_NORMAL);

/** Points as Float32Array or Float64Array. */
function coordinates(list, what) {
  if (!(list instanceof Float32Array || list instanceof Float64Array)) {
    if (!Array.isArray(list)) throw new TypeError(`${what} must be a Float32Array, a Float64Array or an array of numbers`);
    list = Float64Array.from(list);
  }
  if (list.length % 3) throw new RangeError(`${what} has ${list.length} numbers: expected three for each point`);
  return list;
}

function output(out, count) {
  out ??= new Float32Array(count);
  if (!(out instanceof Float32Array)) throw new TypeError('out must be a Float32Array');
  if (out.length < count) throw new RangeError(`out has room for ${out.length} of ${count} results`);
  return out;
}

/** Copies numbers [first, end) of a list to `at`. Returns their type: VXS_F64 or VXS_F32. */
function putChunk(heap, list, first, end, at) {
  const single = list instanceof Float32Array;
  if (single) heap.f32.set(list.subarray(first, end), at / 4);
  else heap.f64.set(list.subarray(first, end), at / 8);
  return +single;
}

export class Light extends CoreLight {
  lookup(point, { normal, filter } = NO_OPTIONS) {
    const p = vector(point, 'point'), n = normalOf(normal), f = filterOf(filter);
    return this.owner.heap.c.web_lookup(this.at, p[0], p[1], p[2], n[0], n[1], n[2], f[0], f[1]);
  }

  isFull(point, { normal, filter } = {}) {
    return !!this.owner.heap.c.web_is_full(this.at, ...vector(point, 'point'), ...normalOf(normal), ...filterOf(filter));
  }

  lookupMany(points, { normals, filter, out } = {}) {
    const { at } = this, { heap } = this.owner, [width, smooth] = filterOf(filter);
    points = coordinates(points, 'points');
    if (normals) normals = coordinates(normals, 'normals');
    if (normals && normals.length !== points.length) {
      throw new RangeError(`normals has ${normals.length} numbers, points ${points.length}`);
    }
    const count = points.length / 3;
    out = output(out, count);
    const from = heap.scratch, beside = from + 24 * CHUNK, lit = beside + 24 * CHUNK;
    for (let n = 0; n < count; n += CHUNK) {
      const end = Math.min(n + CHUNK, count);
      const type = putChunk(heap, points, 3 * n, 3 * end, from);
      const normalType = normals ? putChunk(heap, normals, 3 * n, 3 * end, beside) : 0;
      heap.c.web_lookup_many(at, from, type, normals ? beside : 0, normalType, end - n, width, smooth, lit);
      out.set(heap.f32.subarray(lit / 4, lit / 4 + end - n), n);
    }
    return out;
  }

  voxel(point, { normal, filter } = {}) {
    const { at } = this, { heap } = this.owner, out = heap.scratch;
    const map = heap.c.web_voxel(at, ...vector(point, 'point'), ...normalOf(normal), ...filterOf(filter), out);
    return map < 0 ? null : { map, voxel: [...new Int32Array(heap.u8.buffer, out, 3)] };
  }

  point(map, coordinates) {
    const { at } = this, { heap } = this.owner, out = heap.scratch;
    heap.c.web_point(at, integer(map, 0, this.maps - 1, 'map'), ...vector(coordinates, 'coordinates'), out);
    return [...heap.f64.subarray(out / 8, out / 8 + 3)];
  }

  firstShadow(map, i, j) {
    const last = this.resolution - 1;
    integer(map, 0, this.maps - 1, 'map');
    return this.owner.heap.c.web_first_shadow(this.at, map, integer(i, 0, last, 'i'), integer(j, 0, last, 'j'));
  }

  intervals(origin, direction, tBegin = 0, tEnd = Infinity) {
    const { at } = this, { heap } = this.owner, { c } = heap;
    const ray = heap.scratch, walk = ray + 64, to = walk + (c.web_walk_bytes() + 15 & ~15);
    heap.f64.set([...vector(origin, 'origin'), ...vector(direction, 'direction'), tBegin, tEnd], ray / 8);
    const numbers = typeof tBegin === 'number' && typeof tEnd === 'number';
    if (!numbers || c.web_lit_begin(walk, at, ray)) {
      throw new RangeError('a ray has finite numbers within 1e50, and tEnd, which may be Infinity, is not before tBegin');
    }
    const list = [];
    for (let count = INTERVALS; count === INTERVALS;) {
      count = c.web_lit_next(walk, to, INTERVALS);
      for (let n = 0; n < count; n++) {
        const word = (to + INTERVAL_BYTES * n) / 4;
        const [begin, end] = heap.f64.subarray(word / 2, word / 2 + 2);
        list.push({ begin, end, state: STATES[heap.u32[word + 4]], coarse: !!heap.u32[word + 5] });
      }
    }
    return list;
  }

  get #smoke() { return this.owner.smokeOf(this.index, this.at); }

  get hasSmoke() { return !!this.#smoke; }

  smokeLookup(point) {
    const smoke = this.#smoke, v = vector(point, 'point');
    return smoke ? this.owner.heap.c.web_smoke_lookup(this.at, smoke, ...v) : 1;
  }

  smokeLookupMany(points, { out } = {}) {
    points = coordinates(points, 'points');
    const smoke = this.#smoke, { at } = this, { c } = this.owner.heap, count = points.length / 3;
    out = output(out, count);
    for (let n = 0; n < count; n++) {
      out[n] = smoke ? c.web_smoke_lookup(at, smoke, points[3 * n], points[3 * n + 1], points[3 * n + 2]) : 1;
    }
    return out;
  }

  smokeWords() {
    const smoke = this.#smoke, { heap } = this.owner;
    if (!smoke) return null;
    const [first, count] = heap.counted(heap.c.web_smoke_words, smoke);
    return heap.u32.slice(first, first + count);
  }
}

export class Asset extends CoreAsset {
  smokeOf(index) { return this.heap.c.web_smoke(this.handle, index) >>> 0; }

  get points() {
    const { heap, handle } = this, at = heap.c.web_points(handle) >>> 0;
    if (!at) return null;
    return new Points(this, at);
  }
}

/** Points on casters. */
class Points {
  #owner; #at;
  constructor(owner, at) {
    this.#owner = owner;
    this.#at = at;
    this.count = owner.heap.c.web_point_count(at);
  }

  unpack(origin = [0, 0, 0]) {
    const { heap, handle } = this.#owner, bytes = 16 * this.count, from = vector(origin, 'origin');
    const out = handle && heap.take(bytes);
    try {
      heap.c.web_unpack_points(this.#at, ...from, out);
      return heap.f32.slice(out / 4, (out + bytes) / 4);
    } finally {
      heap.free(out);
    }
  }
}

