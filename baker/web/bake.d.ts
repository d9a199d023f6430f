// SPDX-License-Identifier: GPL-3.0-or-later
/**
 * Bakes the shadows of a glTF scene, in a worker: the command `vxs bake` as WebAssembly. The same bytes, messages and exit statuses as the
 * command. Licensed GPL-3.0-or-later, unlike the runtime: keep it out of what a game ships.
 *
 *     import { bake } from 'vxs/bake';
 *     const { vxs } = await bake(glb, { resolution: 8192, light: ['sun'] });
 */

type Repeated = string | number | (string | number)[];

/**
 * Options of `vxs bake`, in camelCase: `{ ifChanged: true }` is --if-changed, `{ light: ['sun', 'lamp*'] }` is --light sun --light 'lamp*'.
 * What the command refuses rejects with a BakeError.
 */
export interface BakeOptions {
  /** Lights to bake, by name or pattern. Default: all. */
  light?: string | string[];
  /** A light that travels this way: 'X,Y,Z' or 'NAME=X,Y,Z'. */
  sun?: string | string[];
  /** Texels a side of a map, a power of two, 8 to 262144, or 'NAME=N'. Default: 4096. */
  resolution?: Repeated;
  /** Side of a texel in metres, or 'NAME=METRES'. */
  texel?: Repeated;
  /** The box that will be looked up, 'x,y,z,x,y,z' in metres. */
  region?: string;
  /** Name or index of the glTF scene. */
  scene?: string | number;
  /** Nodes, meshes or materials that cast no shadow: 'node:Door*'. */
  exclude?: string | string[];
  include?: string | string[];
  skinned?: 'exclude' | 'rest';
  blend?: 'mask' | 'opaque' | 'exclude';
  exit?: 'auto' | 'peel' | 'back';
  behind?: 'shadow' | 'free';
  /** Thickness of single-sided sheets, in metres. */
  thickness?: number;
  closed?: 'auto' | 'on' | 'off';
  coding?: 'blocks' | 'dag';
  pack?: 'small' | 'fast';
  /** Points for shadows of area lights, 0 to 4194304. */
  points?: number;
  /** zstd level of the file, 1 to 19. Default: 12. */
  level?: number;
  /** Memory that the bake may hold: bytes, or '800M'. At most 4 GiB. */
  memory?: string | number;
  /**
   * Threads, at most 64, each a worker; never changes the bytes. Default: 1. More take a second WebAssembly, and in a browser a page that
   * is cross-origin isolated; elsewhere the bake runs on one.
   */
  threads?: number;
  /** A warning is an error. */
  strict?: boolean;
  [option: string]: unknown;
}

export interface BakeProgress {
  /** Share of the bake that is done, 0 to 1; undefined when it is unknown. */
  share?: number;
  /** What is being done, as 'light sun: tile 1 of 16'. */
  doing: string;
}

export interface BakeSettings {
  /** Called at most ten times a second. */
  onProgress?: (progress: BakeProgress) => void;
  /** Ends the worker at once; bake() rejects with signal.reason. */
  signal?: AbortSignal;
  /** The WebAssembly, when it is not to be fetched from beside the module: baker/vxs.wasm of the package, or with threads vxs-threads.wasm. */
  wasm?: string | URL | Response | BufferSource | WebAssembly.Module;
  /** Files that the scene names: buffers and images of a .gltf, grids of smoke. Names are relative to the scene. */
  files?: Record<string, Uint8Array>;
}

export interface BakeResult {
  /** The asset: bytes of a .vxs file. */
  vxs: Uint8Array;
  /** The report that `vxs bake --json` writes: docs/bake-report.schema.json of the project. */
  report: Record<string, unknown>;
  /** The summary that the command prints. */
  summary: string;
  /** Warnings that the command prints, a line each; '' when there are none. */
  messages: string;
}

/** A bake that failed. `message` is the command's error. */
export class BakeError extends Error {
  /** The exit status of the command: 2 an option, 3 the scene, 6 memory; see the manual. */
  status: number;
  /** All that the command printed to standard error. */
  messages: string;
}

/**
 * @param scene    bytes of a .glb, or the JSON of a .gltf; the caller keeps them
 * @param options  options of the command
 * @throws {BakeError} when the command fails
 */
export function bake(scene: Uint8Array, options?: BakeOptions, settings?: BakeSettings): Promise<BakeResult>;
