// Fog over a picture: of each baked light the lit parts of the air, and light from the sky everywhere.
// SPDX-License-Identifier: MIT
import {
  BufferGeometry,
  Color,
  DepthTexture,
  Float32BufferAttribute,
  HalfFloatType,
  Matrix4,
  Mesh,
  OrthographicCamera,
  ShaderMaterial,
  UnsignedIntType,
  Vector2,
  WebGLRenderTarget,
} from 'three';
import { FogPass } from 'vxs/three';

/** Lights whose air is drawn at once: each is a pass over the picture. */
export const FOG_LIGHTS = 4;

// what the sky adds, divided by the transmittance, which the pass of the first light multiplies
const HAZE = `
uniform sampler2D tColor;
uniform highp sampler2D tDepth;
uniform mat4 fromClip;
uniform vec3 sky;
uniform float extinction, farMetres;
varying vec2 vUv;
void main() {
  vec4 at = fromClip * vec4( 2.0 * vec3( vUv, texture2D( tDepth, vUv ).r ) - 1.0, 1.0 );
  float left = max( exp( - extinction * min( length( at.xyz / at.w ), farMetres ) ), 1e-3 );
  gl_FragColor = texture2D( tColor, vUv ) + vec4( sky * ( 1.0 - left ) / left, 0.0 );
}`;

const picture = (samples) =>
  new WebGLRenderTarget(1, 1, { type: HalfFloatType, samples, depthBuffer: samples > 0 });

export class Fog {
  constructor(renderer, camera) {
    Object.assign(this, { renderer, camera, on: false, extinction: 0.01, passes: [] });
    this.targets = [picture(4), picture(0), picture(0)];
    this.targets[0].depthTexture = new DepthTexture(1, 1, UnsignedIntType);
    const value = (it) => ({ value: it });
    this.haze = new Mesh(
      new BufferGeometry().setAttribute(
        'position',
        new Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3),
      ),
      new ShaderMaterial({
        uniforms: {
          tColor: value(null),
          tDepth: value(null),
          fromClip: value(new Matrix4()),
          sky: value(new Color()),
          extinction: value(0),
          farMetres: value(1),
        },
        vertexShader:
          'varying vec2 vUv; void main() { vUv = 0.5 * position.xy + 0.5; gl_Position = vec4( position.xy, 0.0, 1.0 ); }',
        fragmentShader: HAZE,
        depthTest: false,
        depthWrite: false,
        toneMapped: false,
      }),
    );
    this.haze.frustumCulled = false;
    this.screen = new OrthographicCamera();
  }

  /** New shadows, or null: the passes of the old ones are freed. radius: of the level, metres */
  reset(shadows, radius) {
    this.passes.forEach((pass) => pass.dispose());
    this.passes = [];
    Object.assign(this, { shadows, radius, extinction: 0.05 / radius });
  }

  get available() {
    return !!this.shadows?.pairs.length;
  }

  #passes(lights) {
    const on = new Set(lights);
    if (!this.passes.length)
      this.passes = this.shadows.pairs.map(({ light }) =>
        Object.assign(new FogPass(this.shadows, this.camera, { light }), { light }),
      );
    return this.passes.filter(({ light }) => on.has(light)).slice(0, FOG_LIGHTS);
  }

  /**
   * draw()  draws the picture without fog into the current target
   * lights  those that are on, in order of importance;   sky  Color: radiance of the fog where only the sky lights it
   * output  a target; null: the screen
   */
  render(draw, lights, sky, output = null) {
    const { renderer, camera, extinction } = this,
      size = output ? new Vector2(output.width, output.height) : renderer.getDrawingBufferSize(new Vector2()),
      far = 4 * this.radius;
    const [plain, ...others] = this.targets,
      { tColor, tDepth, ...u } = this.haze.material.uniforms;
    if (plain.width !== size.x || plain.height !== size.y)
      this.targets.forEach((target) => target.setSize(size.x, size.y));
    renderer.setRenderTarget(plain);
    draw();

    tColor.value = plain.texture;
    tDepth.value = plain.depthTexture;
    u.fromClip.value.copy(camera.projectionMatrixInverse);
    u.sky.value.copy(sky);
    u.extinction.value = extinction;
    u.farMetres.value = far;
    renderer.setRenderTarget(others[0]);
    renderer.render(this.haze, this.screen);

    // without a light that is on, one pass is left, which has none: it dims the picture
    const passes = this.#passes(lights),
      drawn = passes.length ? passes : this.passes.slice(0, 1);
    drawn.forEach((pass, n) => {
      Object.assign(pass, { extinction, anisotropy: 0.4, transmits: n === 0, farMetres: far });
      pass.render(renderer, n === drawn.length - 1 ? output : others[(n + 1) % 2], {
        texture: others[n % 2].texture,
        depthTexture: plain.depthTexture,
      });
    });
    renderer.setRenderTarget(null);
  }
}
