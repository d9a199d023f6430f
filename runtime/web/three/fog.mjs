// Homogeneous fog in the light of one baked sun or lamp: for each pixel the exact lit parts of the eye ray in the file, and of each
// the closed form of its airlight. No steps, no noise, no blur.
// SPDX-License-Identifier: MIT
import { BufferGeometry, Color, Float32BufferAttribute, Matrix3, Matrix4, Mesh, OrthographicCamera, ShaderMaterial, Vector3 } from 'three';
import { VXSError } from 'vxs';
import { vxs_air, vxs_air_light, vxs_air_path, vxs_air_ray, vxs_depths, vxs_intervals } from 'vxs/shaders';
import { readers } from './text.mjs';
import { TEXELS, commonMacros, integerTexture, writeConstants } from './words.mjs';

const fragment = (macros, wide) => `
#define VXS_ONLY_EVERYWHERE
${readers(macros, wide)}
${vxs_depths}
${vxs_intervals}
${vxs_air_light}
${vxs_air_ray}
${vxs_air}
${vxs_air_path}
uniform sampler2D tColor;
uniform highp sampler2D tDepth;
uniform mat4 fromClip; // clip space to the space of the camera
uniform mat3 toWorld;
uniform bool reversed, orthographic, transmits;
uniform vec3 extinction, scattering, lightColor, place, axis;
uniform float anisotropy, cosInner, radius, farMetres;
varying vec2 vUv;

void main() {
  float depth = texture2D( tDepth, vUv ).r, z = reversed ? depth : 2.0 * depth - 1.0;
  vec4 at = fromClip * vec4( 2.0 * vUv - 1.0, z, 1.0 ), near = fromClip * vec4( 2.0 * vUv - 1.0, reversed ? 1.0 : - 1.0, 1.0 );
  vec3 eye = orthographic ? vec3( near.xy / near.w, 0.0 ) : vec3( 0.0 );
  float metres = min( length( at.xyz / at.w - eye ), farMetres );
  vec3 direction = toWorld * ( orthographic ? vec3( 0.0, 0.0, - 1.0 ) : normalize( near.xyz / near.w ) );
  eye = toWorld * eye;

  vxs_light_constants light = vxsLight( 0 );
  vxs_medium medium;
  medium.extinction = extinction;
  medium.scattering = scattering;
  medium.anisotropy = anisotropy;
  vxs_air_light source;
  source.kind = VXS_KIND( light );
  source.place = place;
  source.axis = axis;
  source.cos_inner = cosInner;
  source.cos_outer = light.cos_outer;
  source.radius_metres = radius;
  source.range_metres = light.range_metres;
  vec2 inFog;
  vxs_air_path path = vxs_air_path_of( source, eye, direction, metres, VXS_AIR_EVERYWHERE, inFog );
  path.end = vxs_air_seen_to( medium, path, VXS_AIR_DEPTH_MAX );

  vec3 sum = vec3( 0.0 ), air;
  if ( path.end > path.begin ) {
    vxs_walk walk = vxs_walk_of( light, eye, direction, path.begin, path.end );
    vxs_span span;
    if ( VXS_KIND( light ) == VXS_LIGHT_KIND_DIRECTIONAL ) walk.outside = VXS_SPAN_LIT; // nothing is in shadow beyond the map
    while ( vxs_walk_is_on( walk ) != 0 )
      if ( vxs_walk_some( light.first_word, light, walk, VXS_SPAN_LIT, 8, span ) != 0 ) {
        vxs_air_lit( medium, path, span.begin, span.end, air );
        sum += air;
      }
  }
  vec4 color = texture2D( tColor, vUv );
  if ( transmits ) color.rgb *= exp( - extinction * metres );
  gl_FragColor = vec4( color.rgb + sum * lightColor, color.a );
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}`;

/**
 * A pass for EffectComposer of three.js, or to call render() of: readBuffer must have a depthTexture. index.d.ts describes options.
 */
export class FogPass {
  constructor(shadows, camera, { light, extinction = 0.01, scattering, anisotropy = 0.4, transmits = true, farMetres } = {}) {
    this.pair = shadows.pairs.find((pair) => !light || pair.light === light || pair.baked.name === light);
    if (!this.pair) throw new VXSError('argument', 'FogPass needs a light that attach() has matched');
    Object.assign(this, { shadows, camera, extinction, scattering: scattering ?? extinction, anisotropy, transmits, farMetres });
    Object.assign(this, { enabled: true, needsSwap: true, clear: false, renderToScreen: false, isPass: true }); // as passes of three.js
    const { baked } = this.pair, { texture, wide } = shadows.words;
    this.template = baked.constants();
    this.constants = integerTexture(new Uint32Array(4 * TEXELS), TEXELS, 1, 4);
    const value = (it) => ({ value: it });
    this.material = new ShaderMaterial({
      uniforms: {
        vxsWords: value(texture), vxsLights: value(this.constants), tColor: value(null), tDepth: value(null), fromClip: value(new Matrix4()),
        toWorld: value(null), reversed: value(false), orthographic: value(false), transmits: value(true), extinction: value(new Vector3()), scattering: value(new Vector3()),
        lightColor: value(new Color()), place: value(new Vector3()), axis: value(new Vector3()), anisotropy: value(0), cosInner: value(1),
        radius: value(0.01), farMetres: value(1),
      },
      vertexShader: 'varying vec2 vUv; void main() { vUv = 0.5 * position.xy + 0.5; gl_Position = vec4( position.xy, 0.0, 1.0 ); }',
      fragmentShader: fragment(commonMacros([baked], { width: 1, smooth: false }), wide),
      depthTest: false, depthWrite: false,
    });
    const triangle = new BufferGeometry().setAttribute('position', new Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3));
    this.mesh = new Mesh(triangle, this.material);
    this.mesh.frustumCulled = false;
    this.screen = new OrthographicCamera();
  }

  setSize() {}

  #update(renderer) {
    const { light, baked } = this.pair, { camera, shadows } = this, u = this.material.uniforms;
    const { logarithmicDepthBuffer } = renderer.capabilities;
    if (logarithmicDepthBuffer) throw new VXSError('unsupported', 'FogPass cannot read a logarithmic depth buffer');
    camera.updateWorldMatrix(true, false);
    light.updateWorldMatrix(true, false);
    light.target?.updateWorldMatrix(true, false);
    const eye = new Vector3().setFromMatrixPosition(camera.matrixWorld), place = new Vector3().setFromMatrixPosition(light.matrixWorld);
    const axis = light.target ? new Vector3().setFromMatrixPosition(light.target.matrixWorld).sub(place).normalize() : new Vector3();
    const perMetre = (value) => (typeof value === 'number' ? new Vector3(value, value, value) : new Vector3(...(value.toArray?.() ?? value)));
    writeConstants(this.constants.image.data, 0, baked, this.template, shadows.words.first.get(baked), eye, shadows.fromRoot);
    this.constants.needsUpdate = true;
    u.fromClip.value.copy(camera.projectionMatrixInverse);
    u.toWorld.value = new Matrix3().setFromMatrix4(new Matrix4().extractRotation(camera.matrixWorld));
    u.reversed.value = renderer.state.buffers.depth.getReversed?.() ?? false;
    u.orthographic.value = camera.isOrthographicCamera === true;
    u.transmits.value = this.transmits;
    u.extinction.value.copy(perMetre(this.extinction));
    u.scattering.value.copy(perMetre(this.scattering));
    u.anisotropy.value = this.anisotropy;
    u.lightColor.value.copy(light.color).multiplyScalar(light.visible ? light.intensity : 0);
    u.place.value.copy(baked.kind === 'directional' ? axis.clone().negate() : place.sub(eye));
    u.axis.value.copy(axis);
    u.cosInner.value = baked.kind === 'spot' ? Math.cos(light.angle * (1 - light.penumbra)) : 1;
    u.farMetres.value = this.farMetres ?? camera.far;
  }

  /** writeBuffer  a target, null: the screen;   readBuffer  { texture, depthTexture } of the picture without fog */
  render(renderer, writeBuffer, readBuffer) {
    const { tColor, tDepth } = this.material.uniforms;
    if (!readBuffer.depthTexture) throw new VXSError('argument', 'FogPass reads readBuffer.depthTexture: make the target with one');
    this.#update(renderer);
    tColor.value = readBuffer.texture;
    tDepth.value = readBuffer.depthTexture;
    const before = renderer.getRenderTarget();
    renderer.setRenderTarget(this.renderToScreen ? null : writeBuffer);
    renderer.render(this.mesh, this.screen);
    renderer.setRenderTarget(before);
  }

  dispose() {
    this.mesh.geometry.dispose();
    this.material.dispose();
    this.constants.dispose();
  }
}
