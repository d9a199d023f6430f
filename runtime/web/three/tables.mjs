// Depths of a light of palette blocks, laid out for walks of rays: the tables of runtime/gl/gl_tables.h, without slopes. In words a
// shader needs some 30 fetches to find a tile, in tables 5.
// SPDX-License-Identifier: MIT
import { VXSError } from 'vxs';

const WHOLE = 0x80000000, NEVER = 0x3fffffff, UNUSED = 0x7fffffff; // a delta of texels without shadow; one that no texel has
const NODE_WORDS = 4 + 64, BLOCK_WORDS = 2 + 2 * 16, MOST_WORDS = 2 ** 28;

/** Words that grow; equal records are stored once. */
class Words {
  #places = new Map(); // of records, by hash

  constructor() {
    this.data = new Uint32Array(1 << 16);
    this.count = 0;
  }

  /** Append words of 0. Returns the index of the first. */
  append(count) {
    const at = this.count, { data } = this;
    this.count += count;
    if (this.count > MOST_WORDS) throw new VXSError('memory', `the tables of a light have more than ${MOST_WORDS} words`);
    if (this.count > data.length) {
      this.data = new Uint32Array(2 * this.count);
      this.data.set(data);
    }
    return at;
  }

  put(record, count) {
    let hash = count, same = 0;
    for (let n = 0; n < count; n++) hash = Math.imul(hash ^ record[n] ^ (hash >>> 15), 0x9e3779b1);
    const there = this.#places.get(hash);
    while (there !== undefined && same < count && there + same < this.count && this.data[there + same] === record[same]) same++;
    if (same === count) return there;
    const at = this.append(count);
    for (let n = 0; n < count; n++) this.data[at + n] = record[n];
    this.#places.set(hash, at);
    return at;
  }
}

const texels = new Int32Array(64), sorted = new Int32Array(64), record = new Uint32Array(63 + 2 * 6);

/** Make `record` of the deltas in `texels`, of which the least is 0. Returns bits and words. */
function makeRecord() {
  let count = 0, words = 0, bits = 0;
  for (let n = 0; n < 64; n++) {
    const delta = texels[n];
    let at = count;
    while (at > 0 && sorted[at - 1] > delta) at--;
    if (at > 0 && sorted[at - 1] === delta) continue;
    sorted.copyWithin(at + 1, at, count++);
    sorted[at] = delta;
  }
  while (1 << bits < count) bits++;
  for (let level = 0; level < bits; level++) // of a search tree
    for (let n = 0; n < 1 << level; n++) {
      const index = (2 * n + 1) << (bits - level - 1);
      record[words++] = index < count ? sorted[index] : UNUSED;
    }
  record.fill(0, words, words + 2 * bits);
  for (let n = 0; n < 64; n++) {
    let rank = 0;
    for (let step = 1 << (bits - 1); step > 0; step >>= 1) if (rank + step < count && sorted[rank + step] <= texels[n]) rank += step;
    for (let plane = 0; plane < bits; plane++) record[words + 2 * plane + (n >> 5)] |= ((rank >> (bits - 1 - plane)) & 1) << (n & 31);
  }
  return { bits, words: words + 2 * bits };
}

/** Least and greatest of the depths of a square of texels. */
function boundsOf(depths, wide, x, y, side) {
  let least = depths[x + wide * y], greatest = least;
  for (let row = y; row < y + side; row++)
    for (let at = wide * row + x, end = at + side; at < end; at++) {
      const depth = depths[at];
      if (depth < least) least = depth;
      else if (depth > greatest) greatest = depth;
    }
  return [least, greatest];
}

/** The word of a block at texel (x, y) of a square whose side is `wide`. */
function blockOf(out, depths, wide, x, y, far) {
  const [least, greatest] = boundsOf(depths, wide, x, y, Math.min(wide, 32));
  if (least === greatest) return WHOLE | least;
  const at = out.append(BLOCK_WORDS);
  out.data[at] = least;
  out.data[at + 1] = greatest;
  for (let n = 0; n < 16; n++) {
    const i = x + 8 * (n & 3), j = y + 8 * (n >> 2), word = at + 2 + 2 * n;
    if (i >= wide || j >= wide) continue;
    const [low, high] = boundsOf(depths, wide, i, j, 8);
    out.data[word] = low;
    if (low === high) continue;
    for (let t = 0; t < 64; t++) {
      const depth = depths[i + (t & 7) + wide * (j + (t >> 3))];
      texels[t] = depth < far ? depth - low : NEVER;
    }
    const { bits, words } = makeRecord(), place = out.put(record, words);
    out.data[word + 1] = bits * 2 ** 28 + place;
  }
  return at;
}

/** The word of a square in the top. */
function squareOf(out, depths, wide, far) {
  const [least, greatest] = boundsOf(depths, wide, 0, 0, wide);
  if (least === greatest) return WHOLE | least;
  const at = out.append(NODE_WORDS);
  out.data[at + 1] = least;
  out.data[at + 2] = greatest;
  for (let n = 0; n < 64; n++) {
    const x = 32 * (n & 7), y = 32 * (n >> 3), word = x < wide && y < wide ? blockOf(out, depths, wide, x, y, far) : WHOLE;
    out.data[at + 4 + n] = word;
  }
  return at;
}

/** The tables of a baked light; indices count from their first word. */
export function tablesOf(light) {
  const { resolution: far, maps } = light, wide = Math.min(far, 256), across = far / wide, out = new Words();
  const top = out.append(maps * across * across);
  for (let map = 0, n = 0; map < maps; map++)
    for (let y = 0; y < far; y += wide)
      for (let x = 0; x < far; x += wide, n++) {
        const { data } = light.depthMap({ map, voxels: true, x, y, width: wide, height: wide }), word = squareOf(out, data, wide, far);
        out.data[top + n] = word;
      }
  return out.data.subarray(0, out.count);
}
