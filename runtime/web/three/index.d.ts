// SPDX-License-Identifier: MIT
import type {
  Camera, Color, ColorRepresentation, DataTexture, DepthTexture, Light, Loader, LoadingManager, Object3D, Texture, Vector3, WebGLRenderer, WebGLRenderTarget,
} from 'three';
import type { Asset, Focus, Light as BakedLight, Runtime, Stream, StreamOptions, StreamStatus } from 'vxs';

export { VXSError } from 'vxs';

/** An exact filter of K x K texels: { box: K }, K odd, 1 to 17; { smooth: K }, any K of 1 to 17; a number K is { box: K }. */
export type Filter = number | { box: number } | { smooth: number };

export interface AttachOptions {
  /**
   * 'lookup' (default): exact answers in the materials of the scene, for any number of lights. 'depth': the map as a depth texture in
   * light.shadow.map; three.js filters it, and renders no shadow pass.
   */
  way?: 'lookup' | 'depth';
  /** Of the way 'lookup'; { box: 9 } by default. */
  filter?: Filter;
  /** Needed by the way 'depth'. VSMShadowMap is refused; point lights need three.js r182 or later. */
  renderer?: WebGLRenderer;
  /** Texels along a side of a depth texture, a power of two; 4096 by default, at most that of the light. */
  resolution?: number;
  /**
   * Objects that move, with all below them: they alone cast into live shadow maps of three.js (castShadow of all other meshes of the
   * target becomes false, for lights without a baked shadow, too), whose answer is multiplied with the baked one. For the way
   * 'lookup'; renderer.shadowMap.enabled must be true: pass the renderer, or set it.
   */
  movers?: Object3D[];
}

export interface Match {
  /** moved: the light is no longer where it was when it was baked, so its shadow is wrong. */
  matched: { light: Light; baked: BakedLight; moved: boolean }[];
  /** Lights of the scene without a baked shadow. */
  lights: Light[];
  /** Baked lights that no light of the scene matches. */
  baked: BakedLight[];
}

/** The shadows of a file, attached to one scene at a time. */
export class BakedShadows {
  readonly asset: Asset;
  readonly lights: readonly BakedLight[];
  /** What the last attach() matched; empty after detach(). */
  readonly pairs: Match['matched'];
  /** Words of all lights, R32UI, `wide` texels in a row: word n of a light is at first.get(light) + n. */
  readonly words: { texture: DataTexture; wide: number; first: Map<BakedLight, number> };
  /**
   * Let the lights below a scene, or of a result of GLTFLoader, shine with their baked shadows. Lights match by name, else by place.
   * Sets receiveShadow of meshes; their lit materials (Standard, Physical, Lambert, Phong, Toon) are extended by the
   * way 'lookup'. The root may be moved and turned, not scaled. An earlier attachment is undone first. Throws VXSError; then nothing
   * is attached, and the scene is as it was before.
   */
  attach(target: Object3D | { scene: Object3D; parser?: unknown }, options?: AttachOptions): Match;
  /** Shade meshes that came after attach(). */
  add(object: Object3D): void;
  /** Another filter of the way 'lookup'; materials are compiled again. */
  setFilter(filter: Filter): void;
  /** Undo attach(). */
  detach(): void;
  /** detach(), and free textures and the file. */
  dispose(): void;
}

/** Shadows of a file that is read by ranges, with the way 'lookup'. */
export interface StreamedShadows extends Omit<BakedShadows, 'asset'> {
  readonly asset: Stream;
  /** As frame() of a stream, once a frame. The next rendering uploads what came; all words, with WebGPURenderer or three.js r170. */
  frame(foci?: Focus | readonly Focus[]): StreamStatus;
}

/** A light that a baked one describes, at its place: for Match.baked, of a bake with --sun. intensity: lux 3, candela 100 by default. */
export function lightOf(baked: BakedLight, color?: ColorRepresentation, intensity?: number): Light;

export interface FogOptions {
  /** A light that attach() has matched, or its name in the file; the first by default. */
  light?: Light | string;
  /** Extinction and scattering per metre: a number, or one for each of red, green, blue. Defaults: 0.01, and all that is extinct. */
  extinction?: number | [number, number, number] | Vector3 | Color;
  scattering?: number | [number, number, number] | Vector3 | Color;
  /** g of the phase function, -0.99 (light turns back) to 0.99 (goes on); 0.4 by default. */
  anisotropy?: number;
  /** false: fog does not dim the picture: for a second pass, of another light. */
  transmits?: boolean;
  /** Fog ends here where no surface is seen; camera.far by default. */
  farMetres?: number;
  /**
   * true: a ray for 2 x 2 pixels, and each pixel takes those that end near its own end: a quarter of the time. Light does not cross
   * edges, but detail of a pixel in the light is lost.
   */
  half?: boolean;
}

/**
 * Homogeneous fog, lit by one baked light: the lit parts of each eye ray exactly, and their airlight in closed form. A pass for
 * EffectComposer, behind RenderPass, with a target that has a depthTexture; or call render(). Works in linear colours. Options are
 * fields and may change at any time. For another light add a second pass. WebGLRenderer, without logarithmicDepthBuffer. The first pass of
 * a light of up to 16384 texels lays its depths out for rays: 0.2 s and 2 MiB at 4096, 2 s and 9 MiB at 16384.
 */
export class FogPass {
  constructor(shadows: BakedShadows, camera: Camera, options?: FogOptions);
  camera: Camera;
  enabled: boolean;
  renderToScreen: boolean;
  extinction: FogOptions['extinction'];
  scattering: FogOptions['scattering'];
  anisotropy: number;
  transmits: boolean;
  farMetres?: number;
  half: boolean;
  setSize(width: number, height: number): void;
  /** writeBuffer null: the screen. */
  render(renderer: WebGLRenderer, writeBuffer: WebGLRenderTarget | null, readBuffer: { texture: Texture; depthTexture: DepthTexture | null }): void;
  dispose(): void;
}

/** Loads .vxs files. Wrong bytes are a VXSError. */
export class VXSLoader<Shadows = BakedShadows> extends Loader<Shadows> {
  constructor(manager?: LoadingManager);
  /** A runtime of load(), or a promise of one; load() of 'vxs' by default. */
  setRuntime(runtime: Runtime | Promise<Runtime>): this;
  parse(bytes: Uint8Array | ArrayBuffer, onLoad: (shadows: Shadows) => void, onError?: (error: unknown) => void): void;
  parseAsync(bytes: Uint8Array | ArrayBuffer): Promise<Shadows>;
  /** As stream() of 'vxs'. */
  streamAsync(url: string | URL, options: StreamOptions): Promise<StreamedShadows>;
}

/**
 * A plugin of GLTFLoader: loader.register((parser) => new VXSShadowsPlugin(parser)). The result then has `shadows`: BakedShadows, or
 * null. They come from the glTF extension VXS_baked_shadows, or from "extras": { "vxs_shadows": "level.vxs" } of the file or of its
 * scene. Attach them: gltf.shadows?.attach(gltf).
 */
export class VXSShadowsPlugin {
  constructor(parser: unknown, loader?: VXSLoader<unknown>);
  readonly name: 'VXS_baked_shadows';
  afterRoot(result: object): Promise<void>;
}
