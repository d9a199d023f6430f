// SPDX-License-Identifier: MIT
/**
 * vxs/core: what a shader needs of a .vxs file: words, constants, depth maps. 42 KB as brotli, WebAssembly included.
 *
 *     import { load } from 'vxs/core';
 *     const vxs = await load();
 *     const asset = vxs.open(await (await fetch('level.vxs')).arrayBuffer());
 *     const { width, height, data } = asset.light('sun').depthMap({ resolution: 2048 });
 *     asset.dispose();
 *
 * Units are metres in world space, and texels and voxels in the maps of a light.
 */

/** A point, a direction or a normal: three numbers, in metres where it is a point. A Vector3 of three.js is one, too. */
export type Vector = ArrayLike<number> | { readonly x: number; readonly y: number; readonly z: number };

/**
 * Why a file, a server or an object cannot be used. Wrong arguments are a TypeError or a RangeError instead.
 *   code     'notVxs', 'version', 'truncated', 'corrupt': wrong bytes; 'memory': the file needs more than the limit, or
 *            than there is; 'read': a server or the network failed; 'argument': a stream has no light
 *            of a name; 'disposed': used after dispose()
 *   finding  number of the first finding in the list of formats/vxs.md section 8, which `vxs validate` prints; 0: none
 *   section  section of the file, from 0; -1: header or directory.   offset  byte in that section
 */
export class VXSError extends Error {
  readonly name: 'VXSError';
  readonly code: 'notVxs' | 'version' | 'truncated' | 'corrupt' | 'memory' | 'read' | 'argument' | 'disposed';
  readonly finding: number;
  readonly section: number;
  readonly offset: number;
}

/** Where load() gets its WebAssembly. Default: the file beside the module. A compiled module may be shared by workers. */
export interface LoadOptions {
  wasm?: WasmSource | Promise<WasmSource>;
}
export type WasmSource = URL | string | Response | BufferSource | WebAssembly.Module;

export interface OpenOptions {
  /** Most bytes that the file may need, its working memory included. Default: 256 times its size, at least 64 MiB. */
  memoryLimit?: number;
}

/** A rectangle of a map, as a depth map. All numbers are integers. */
export interface DepthMapOptions {
  /** Which map of the light, 0 to maps - 1. Default 0 */
  map?: number;
  /** Pixels along a side of the whole map: a power of two up to the light's. Excludes `shift`. */
  resolution?: number;
  /** A pixel covers 2^shift x 2^shift texels, 0 to levels. Default 0 */
  shift?: number;
  /** Of the texels of a pixel: the one at its middle, the nearest or the farthest depth. Default 'centre' */
  which?: 'centre' | 'least' | 'greatest';
  /** First pixel, and size in pixels. Default: all of the map. Pixels outside the map are lit at all depths. */
  x?: number;
  y?: number;
  width?: number;
  height?: number;
}

export interface DepthMap<Data extends Float32Array | Uint32Array> {
  width: number;
  height: number;
  /** [height * width] in rows: where shadow begins */
  data: Data;
}

/** A light of a file. Its fields are those of vxs_light (formats/vxs_file.h). Usable until its file is disposed of. */
export interface CoreLight {
  /** In file order, or in that of the lights that a stream was opened with. */
  readonly index: number;
  /** Unique in the file. */
  readonly name: string;
  readonly kind: 'directional' | 'spot' | 'point';
  readonly coding: 'blocks' | 'dag';
  readonly packing: 'small' | 'fast';
  /** A map has 2^levels texels a side, and as many voxels in depth: 3 to 18. */
  readonly levels: number;
  /** 2^levels */
  readonly resolution: number;
  /** 1, or 6: the faces of a cube. */
  readonly maps: 1 | 6;
  /** A directional light whose volume ends at the near and far sides of its map. */
  readonly bounded: boolean;
  readonly wordCount: number;
  /** Side of a texel; spot and point: at one metre from the light. */
  readonly texelMetres: number;
  /** Depth of a voxel; spot and point: of one metre from the light. */
  readonly voxelMetres: number;
  /** Spot and point: distance of depth 0; else 0. */
  readonly nearMetres: number;
  /** Spot and point: distance where the volume ends; 0: no end. */
  readonly rangeMetres: number;
  /** Spot: cosine of the half angle of its cone; else 0. */
  readonly cosOuter: number;
  /** Unit vector: the way the light travels. */
  readonly direction: readonly number[];
  /** [12] three rows of four, from world metres: to texels, texels and voxels; spot and point: to metres about the light. */
  readonly matrix: Float64Array;

  /** A copy of the words, [wordCount], for a buffer or texture that shaders read. Put four zeros behind the words of all lights. */
  words(): Uint32Array;
  /**
   * A copy of the light's struct vxs_light_constants: 96 bytes, for std140, std430 and WGSL.
   * @param origin     positions in the shader are relative to it. Default: the world's origin
   * @param firstWord  index of the light's first word in the array of all words. Default 0; of a stream: where they are
   */
  constants(origin?: Vector, firstWord?: number): Uint8Array;
  /** Depths 0 near to 1 far, or with `voxels` in voxels, 0 to resolution: no shadow. Throws a RangeError for wrong options. */
  depthMap(options?: DepthMapOptions & { voxels?: false }): DepthMap<Float32Array>;
  depthMap(options: DepthMapOptions & { voxels: true }): DepthMap<Uint32Array>;
}

/** An open file. Its memory is freed by dispose(); or, some time after nothing refers to it, by the garbage collector. */
export interface CoreAsset<L extends CoreLight = CoreLight> {
  readonly lights: readonly L[];
  /** Throws a RangeError if there is no such light. */
  light(indexOrName: number | string): L;
  /** The metadata that the baker wrote; null: none. */
  readonly info: Record<string, unknown> | null;
  readonly disposed: boolean;
  /** Frees the memory; all else throws a VXSError afterwards, but for fields of lights. May be called again. */
  dispose(): void;
}

/** An instance with memory of its own, which grows with the files that are open, and never shrinks. */
export interface CoreRuntime {
  /**
   * Checks all bytes and decodes them. Blocks: about as long as in C; in a page, open large files in a worker.
   * @param bytes  a whole .vxs file; copied, not kept
   * @throws VXSError
   */
  open(bytes: BufferSource, options?: OpenOptions): CoreAsset;
  /** Memory of the instance in bytes. */
  readonly memoryBytes: number;
}

/** Each call makes an instance. @throws VXSError 'read' if the WebAssembly file cannot be had */
export function load(options?: LoadOptions): Promise<CoreRuntime>;
