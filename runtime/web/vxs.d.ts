// SPDX-License-Identifier: MIT
/**
 * vxs: lookups in baked shadows. 67 KB as brotli, WebAssembly included.
 *
 *     import { load } from 'vxs';
 *     const vxs = await load();
 *     const asset = vxs.open(await (await fetch('level.vxs')).arrayBuffer());
 *     const lit = asset.light('sun').lookup([1, 2, 3], { normal: [0, 1, 0], filter: 9 }); // 0 dark to 1 lit; -1 outside
 *     asset.dispose();
 *
 * Results are those of the C library, bit for bit (runtime/vxs.h, vxs_query.h, vxs_stream.h). Nothing is global; instances in
 * several workers do not meet. `vxs/inline` is the same without a separate WebAssembly file; require('vxs') is that, too.
 */
import type { CoreAsset, CoreLight, LoadOptions, OpenOptions, Vector } from './core.js';

export { VXSError } from './core.js';
export type { DepthMap, DepthMapOptions, LoadOptions, OpenOptions, Vector, WasmSource } from './core.js';

/**
 * A box of K x K texels over which shadow is averaged: a number or { box: K }, K odd, 1 to 17, moves in steps of texels;
 * { smooth: K }, K even or odd, is centred at the point itself. Default 1. Others throw a RangeError.
 */
export type Filter = number | { box: number } | { smooth: number };

export interface LookupOptions {
  /** Normal of the surface at the point, of any length: the lookup moves off the surface. */
  normal?: Vector;
  filter?: Filter;
}

export interface LookupManyOptions {
  /** As many numbers as points. */
  normals?: Float32Array | Float64Array | readonly number[];
  filter?: Filter;
  /** Where results go; one for each point or more. Default: a new array. */
  out?: Float32Array;
}

/** Part of a ray, [begin, end), in units of its direction. */
export interface Interval {
  begin: number;
  end: number;
  state: 'lit' | 'shadow' | 'outside';
  /** A page is missing: this is the coarse answer. */
  coarse: boolean;
}

export interface Light extends CoreLight {
  /** In a stream: index of the light's first word in the array of all words. */
  readonly firstWord?: number;
  /** Lit fraction around a point, 0 to 1; -1: outside the light's volume, as are points with NaN or infinity. */
  lookup(point: Vector, options?: LookupOptions): number;
  /** The same for many points: x, y, z of each. Fastest for points near one another. Returns `out`. */
  lookupMany(points: Float32Array | Float64Array | readonly number[], options?: LookupManyOptions): Float32Array;
  /** Whether lookup() is exact: in a stream it is coarse where pages are missing. */
  isFull(point: Vector, options?: LookupOptions): boolean;
  /** The voxel of a point, which may be outside the map: texels, texels, depth. null: outside the light's volume. */
  voxel(point: Vector, options?: LookupOptions): { map: number; voxel: [number, number, number] } | null;
  /** The point in world space of fractional texels u, v and depth in voxels. */
  point(map: number, coordinates: Vector): [number, number, number];
  /** First voxel in shadow of texel (i, j), 0 to resolution: no shadow. */
  firstShadow(map: number, i: number, j: number): number;
  /**
   * Lit parts of the points origin + t direction, t from tBegin (default 0) to tEnd (default Infinity), without gaps.
   * Throws a RangeError for NaN, numbers beyond 1e50, or a tEnd before tBegin.
   */
  intervals(origin: Vector, direction: Vector, tBegin?: number, tEnd?: number): Interval[];
  /** Whether the file has baked smoke for this light. */
  readonly hasSmoke: boolean;
  /** Part of the light that baked smoke lets through to a point, 0 to 1: a factor of lookup(). 1 without smoke. */
  smokeLookup(point: Vector): number;
  smokeLookupMany(points: Float32Array | Float64Array | readonly number[], options?: { out?: Float32Array }): Float32Array;
  /** A copy of the words of the smoke, for vxs_smoke.h; null: none. */
  smokeWords(): Uint32Array | null;
}

/** Points on the surfaces that cast shadow. */
export interface Points {
  readonly count: number;
  /** [4 * count]: position in metres, relative to an origin near it; area in square metres that the point represents. */
  unpack(origin?: Vector): Float32Array;
}

export interface Asset extends CoreAsset<Light> {
  /** null: the file has none. */
  readonly points: Points | null;
}

/** Where lookups will be: a point, or a box from min to max, in metres. */
export type Focus = ({ position: Vector } | { min: Vector; max: Vector }) & {
  /** Pages farther from the box are not wanted; 0: no limit. Default 0 */
  radius?: number;
  /** Above 0; distances are divided by it. Default 1 */
  weight?: number;
};

export interface StreamOptions {
  /** Memory of the stream in bytes: more is never held, and open fails with code 'memory' if it is too little. */
  budgetBytes: number;
  /** Names of the lights to open, in this order. Default: all */
  lights?: readonly string[];
  /** Default: globalThis.fetch. Called with the headers `range` and `accept-encoding`, and a signal. */
  fetch?: (url: string, init: { headers: Record<string, string>; signal: AbortSignal }) => Promise<Response>;
  /** Pages that are read at once, 1 to 64. Default 6 */
  requests?: number;
  /** Most pages that a frame decodes, 1 to 64; each takes some milliseconds. Default 1 */
  decodesPerFrame?: number;
  /** A read that takes longer has failed, and is tried again. Default 30 000 */
  timeoutMs?: number;
  /** Ends opening. */
  signal?: AbortSignal;
}

/** State of a stream, in pages and bytes; `reads` to `left` count what has happened since the last frame (vxs_stream.h). */
export interface StreamStatus {
  bytesHeld: number;
  bytesResident: number;
  bytesRoom: number;
  bytesRead: number;
  pages: number;
  pagesResident: number;
  pagesWanted: number;
  pagesMissing: number;
  pagesComing: number;
  pagesFailed: number;
  reads: number;
  decodes: number;
  appeared: number;
  left: number;
  /** Pages that could not be loaded. 'read': tried again 8, 16, 32.. frames later, six times in all; 'corrupt': after retry(). */
  failures: { light: number; page: number; code: 'read' | 'corrupt'; finding: number }[];
}

/** A file larger than memory. Lookups work at any time: coarse where pages are missing. They change in frame() alone. */
export interface Stream {
  readonly lights: readonly Light[];
  light(indexOrName: number | string): Light;
  readonly info: Record<string, unknown> | null;
  /** false: the server does not serve ranges, so the whole file was downloaded and is kept in memory besides the budget. */
  readonly ranges: boolean;
  /** Words of all lights: resident parts, smoke, room for pages. */
  readonly wordCount: number;
  /** Once per frame: pages that have come appear, others make room, missing ones are requested, the nearest first. */
  frame(foci?: Focus | readonly Focus[]): StreamStatus;
  /** Frames until no wanted page can come any more: for a loading screen. */
  load(foci: Focus | readonly Focus[]): Promise<StreamStatus>;
  /** Requests failed pages again. */
  retry(): void;
  /** A copy of words, for a buffer or texture that shaders read. Default: all */
  words(firstWord?: number, count?: number): Uint32Array;
  /** What frames have changed since the last call, to keep such a copy current. */
  changes(): { firstWord: number; words: Uint32Array }[];
  readonly disposed: boolean;
  /** Ends all reads, and frees the memory. */
  dispose(): void;
}

/** An instance with memory of its own, which grows with the files that are open, and never shrinks. */
export interface Runtime {
  /**
   * Checks all bytes and decodes them. Blocks: about as long as in C; in a page, open large files in a worker.
   * @param bytes  a whole .vxs file; copied, not kept
   * @throws VXSError
   */
  open(bytes: BufferSource, options?: OpenOptions): Asset;
  /** Opens a file on a server, which should serve ranges. @throws VXSError; the signal's reason if it ended opening */
  stream(url: string | URL, options: StreamOptions): Promise<Stream>;
  /** Memory of the instance in bytes. */
  readonly memoryBytes: number;
}

/** Each call makes an instance. @throws VXSError 'read' if the WebAssembly file cannot be had */
export function load(options?: LoadOptions): Promise<Runtime>;
