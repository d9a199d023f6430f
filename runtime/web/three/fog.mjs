// Homogeneous fog in the light of one baked sun or lamp: for each pixel the exact lit parts of the eye ray in the file, and of each
// the closed form of its airlight. No steps, no noise, no blur.
// SPDX-License-Identifier: MIT
import { BufferGeometry, Float32BufferAttribute, HalfFloatType, Matrix3, Matrix4, Mesh, OrthographicCamera, ShaderMaterial, Vector3, WebGLRenderTarget } from 'three';
import { VXSError } from 'vxs';
import { FogLight, perMetre } from './fog_light.mjs';
import { airReaders } from './text.mjs';

const RAY = `
uniform sampler2D tColor, tAir;
uniform highp sampler2D tDepth;
uniform mat4 fromClip; // clip space to the space of the camera
uniform mat3 toWorld;
uniform bool reversed, orthographic, transmits;
uniform vec3 extinction;
uniform float farMetres;
varying vec2 vUv;

// metres to what is seen, at most to the end of the fog; eye and direction in axes of the world
float vxsEyeRay( vec2 uv, float depth, out vec3 eye, out vec3 direction ) {
  float z = reversed ? depth : 2.0 * depth - 1.0;
  vec4 at = fromClip * vec4( 2.0 * uv - 1.0, z, 1.0 ), near = fromClip * vec4( 2.0 * uv - 1.0, reversed ? 1.0 : - 1.0, 1.0 );
  eye = orthographic ? vec3( near.xy / near.w, 0.0 ) : vec3( 0.0 );
  float metres = min( length( at.xyz / at.w - eye ), farMetres );
  direction = toWorld * ( orthographic ? vec3( 0.0, 0.0, - 1.0 ) : normalize( near.xyz / near.w ) );
  eye = toWorld * eye;
  return metres;
}

void vxsShow( vec3 air, float metres ) {
  vec4 color = texture2D( tColor, vUv );
  if ( transmits ) color.rgb *= exp( - extinction * metres );
  gl_FragColor = vec4( color.rgb + air, color.a );
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}
`;

const FULL = `
void main() {
  vec3 eye, direction;
  float metres = vxsEyeRay( vUv, texture2D( tDepth, vUv ).r, eye, direction );
  vxsShow( vxsFog( eye, direction, metres ), metres );
}`;

// A ray for 2 x 2 pixels. One that meets one surface ends there; at an edge it ends at the nearest or at the farthest, in turn, so that
// each pixel finds a ray like its own beside it.
const HALF = `
void main() {
  ivec2 size = textureSize( tDepth, 0 ), pixel = ivec2( gl_FragCoord.xy );
  vec2 ends = vec2( 1e30, - 1.0 ), depths;
  vec3 eye, direction;
  float mean = 0.0;
  for ( int n = 0; n < 4; n ++ ) {
    ivec2 at = min( 2 * pixel + ivec2( n & 1, n >> 1 ), size - 1 );
    float depth = texelFetch( tDepth, at, 0 ).r, metres = vxsEyeRay( ( vec2( at ) + 0.5 ) / vec2( size ), depth, eye, direction );
    if ( metres < ends.x ) { ends.x = metres; depths.x = depth; }
    if ( metres > ends.y ) { ends.y = metres; depths.y = depth; }
    mean += 0.25 * depth;
  }
  float depth = ends.y <= 1.1 * ends.x && ends.y < farMetres ? mean : ( ( pixel.x + pixel.y ) & 1 ) == 0 ? depths.x : depths.y;
  float metres = vxsEyeRay( vec2( 2 * pixel + 1 ) / vec2( size ), depth, eye, direction );
  gl_FragColor = vec4( vxsFog( eye, direction, metres ), metres );
}`;

// The four nearest of these rays, bilinearly, and by how near they end to the pixel's own end. One that ends elsewhere counts in
// proportion to the fog on both.
const WHOLE = `
vec3 vxsTaken( float metres ) {
  vec3 depth = extinction * metres;
  return metres * mix( 1.0 - 0.5 * depth, ( 1.0 - exp( - depth ) ) / max( depth, 1e-30 ), step( 1e-3, depth ) );
}

void main() {
  vec3 eye, direction;
  float metres = vxsEyeRay( vUv, texture2D( tDepth, vUv ).r, eye, direction );
  vec2 place = 0.5 * gl_FragCoord.xy - 0.5, between = fract( place );
  vec4 sum = vec4( 0.0 );
  for ( int n = 0; n < 4; n ++ ) {
    ivec2 corner = ivec2( n & 1, n >> 1 ), at = clamp( ivec2( floor( place ) ) + corner, ivec2( 0 ), textureSize( tAir, 0 ) - 1 );
    vec2 weight = mix( 1.0 - between, between, vec2( corner ) );
    vec4 ray = texelFetch( tAir, at, 0 );
    float apart = min( abs( ray.a - metres ) / ( 0.05 * max( min( ray.a, metres ), 1e-6 ) ), 1e4 );
    apart *= apart * apart * apart;
    vec3 scale = mix( vec3( 1.0 ), min( vxsTaken( metres ) / max( vxsTaken( ray.a ), 1e-30 ), 4.0 ), apart / ( 1.0 + apart ) );
    sum += weight.x * weight.y / ( 1.0 + apart ) * vec4( ray.rgb * scale, 1.0 );
  }
  vxsShow( sum.rgb / sum.w, metres );
}`;

const vertexShader = 'varying vec2 vUv; void main() { vUv = 0.5 * position.xy + 0.5; gl_Position = vec4( position.xy, 0.0, 1.0 ); }';

/**
 * A pass for EffectComposer of three.js, or to call render() of: readBuffer must have a depthTexture. index.d.ts describes options.
 */
export class FogPass {
  constructor(shadows, camera, { light, extinction = 0.01, scattering, anisotropy = 0.4, transmits = true, farMetres, half = false } = {}) {
    this.fog = new FogLight(shadows, light);
    Object.assign(this, { camera, extinction, scattering: scattering ?? extinction, anisotropy, transmits, farMetres, half });
    Object.assign(this, { enabled: true, needsSwap: true, clear: false, renderToScreen: false, isPass: true }); // as passes of three.js
    const { words, constants, macros } = this.fog, value = (it) => ({ value: it });
    this.uniforms = {
      vxsWords: value(words.texture), vxsLights: value(constants), tColor: value(null), tDepth: value(null), tAir: value(null), fromClip: value(new Matrix4()),
      toWorld: value(new Matrix3()), reversed: value(false), orthographic: value(false), transmits: value(true), extinction: value(new Vector3()), farMetres: value(1),
    };
    const air = airReaders(macros, words.wide), material = (...texts) =>
      new ShaderMaterial({ uniforms: this.uniforms, vertexShader, fragmentShader: texts.join(''), depthTest: false, depthWrite: false });
    this.materials = { full: material(air, RAY, FULL), half: material(air, RAY, HALF), whole: material(RAY, WHOLE) };
    const triangle = new BufferGeometry().setAttribute('position', new Float32BufferAttribute([-1, -1, 0, 3, -1, 0, -1, 3, 0], 3));
    this.mesh = new Mesh(triangle, this.materials.full);
    this.mesh.frustumCulled = false;
    this.screen = new OrthographicCamera();
    this.air = new WebGLRenderTarget(1, 1, { type: HalfFloatType, depthBuffer: false });
  }

  setSize() {}

  #update(renderer) {
    const { camera, uniforms: u } = this, { logarithmicDepthBuffer } = renderer.capabilities;
    if (logarithmicDepthBuffer) throw new VXSError('unsupported', 'FogPass cannot read a logarithmic depth buffer');
    this.fog.update(camera, this);
    u.fromClip.value.copy(camera.projectionMatrixInverse);
    u.toWorld.value.setFromMatrix4(new Matrix4().extractRotation(camera.matrixWorld));
    u.reversed.value = renderer.state.buffers.depth.getReversed?.() ?? false;
    u.orthographic.value = camera.isOrthographicCamera === true;
    u.transmits.value = this.transmits;
    u.extinction.value.set(...perMetre(this.extinction));
    u.farMetres.value = this.farMetres ?? camera.far;
  }

  #draw(renderer, material, target) {
    this.mesh.material = material;
    renderer.setRenderTarget(target);
    renderer.render(this.mesh, this.screen);
  }

  /** writeBuffer  a target, null: the screen;   readBuffer  { texture, depthTexture } of the picture without fog */
  render(renderer, writeBuffer, readBuffer) {
    const { materials, uniforms: { tColor, tDepth, tAir } } = this, { depthTexture } = readBuffer;
    if (!depthTexture) throw new VXSError('argument', 'FogPass reads readBuffer.depthTexture: make the target with one');
    this.#update(renderer);
    tColor.value = readBuffer.texture;
    tDepth.value = depthTexture;
    tAir.value = null;
    const before = renderer.getRenderTarget();
    if (this.half) {
      this.air.setSize(Math.ceil(depthTexture.image.width / 2), Math.ceil(depthTexture.image.height / 2));
      this.#draw(renderer, materials.half, this.air);
      tAir.value = this.air.texture;
    }
    this.#draw(renderer, this.half ? materials.whole : materials.full, this.renderToScreen ? null : writeBuffer);
    renderer.setRenderTarget(before);
  }

  dispose() {
    this.mesh.geometry.dispose();
    Object.values(this.materials).forEach((material) => material.dispose());
    this.fog.dispose();
    this.air.dispose();
  }
}
