// What is behind a level, and lights it from all sides: a sky for levels with a sun, a dark room for others.
// SPDX-License-Identifier: MIT
import {
  Color,
  LightProbe,
  Mesh,
  PMREMGenerator,
  PlaneGeometry,
  Scene,
  ShaderMaterial,
  SphericalHarmonics3,
  Vector3,
} from 'three';

const VERTEX = `
varying vec3 direction;
void main() {
  direction = inverse( mat3( viewMatrix ) ) * ( inverse( projectionMatrix ) * vec4( position.xy, 1.0, 1.0 ) ).xyz;
  gl_Position = vec4( position.xy, 1.0, 1.0 );
}`;

const FRAGMENT = `
varying vec3 direction;
uniform vec3 zenith, horizon, ground, sunColour, sun; // sun: towards it; its length is how much of it is seen
uniform float brightness;
void main() {
  vec3 d = normalize( direction );
  vec3 colour = mix( horizon, zenith, 1.0 - exp( -3.2 * max( d.y, 0.0 ) ) );
  colour = mix( colour, ground, 1.0 - exp( -9.0 * max( - d.y, 0.0 ) ) );
  float seen = length( sun ), near = seen > 0.0 ? max( dot( d, sun / seen ), 0.0 ) : 0.0;
  float above = smoothstep( -0.06, 0.04, d.y );
  colour += seen * above * sunColour * ( 0.30 * pow( near, 6.0 ) + 0.25 * pow( near, 60.0 ) + 1.5 * smoothstep( 0.99985, 0.99993, near ) );
  gl_FragColor = vec4( brightness * colour, 1.0 );
  #include <colorspace_fragment>
}`;

const SKY = { zenith: [0.13, 0.27, 0.52], horizon: [0.62, 0.7, 0.76], ground: [0.47, 0.49, 0.51] };
const BOUNCE = [0.38, 0.35, 0.32]; // what the ground gives back of the sky
const ROOM = { zenith: [0.03, 0.033, 0.04], horizon: [0.018, 0.02, 0.024], ground: [0.008, 0.008, 0.01] };
// a room lights its walls as evenly as a white one would
const ROOM_LIGHT = { zenith: [0.55, 0.56, 0.58], horizon: [0.45, 0.45, 0.46], ground: [0.3, 0.29, 0.28] };

export class Backdrop {
  constructor(renderer) {
    const uniform = (value) => ({ value });
    this.renderer = renderer;
    this.uniforms = {
      zenith: uniform(new Color()),
      horizon: uniform(new Color()),
      ground: uniform(new Color()),
      sunColour: uniform(new Color()),
      sun: uniform(new Vector3()),
      brightness: uniform(1),
    };
    const material = new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader: FRAGMENT,
      uniforms: this.uniforms,
      depthTest: false,
      depthWrite: false,
      toneMapped: false,
    });
    const quad = new Mesh(new PlaneGeometry(2, 2), material);
    quad.frustumCulled = false;
    this.scene = new Scene().add(quad);
    this.environment = null;
    this.colour = new Color(); // of the sky as a whole
    this.harmonics = new SphericalHarmonics3();
  }

  #colours(of) {
    for (const [name, colour] of Object.entries(of)) this.uniforms[name].value.setRGB(...colour);
  }

  /** Light from all sides as spherical harmonics: the sky, brighter about the sun, and what the ground gives back. */
  #findHarmonics(sun) {
    const { zenith, horizon, ground, sunColour } = this.uniforms,
      count = 512,
      basis = new Array(9),
      back = sun ? new Color(...BOUNCE) : ground.value;
    this.harmonics.zero();
    for (let n = 0; n < count; n++) {
      const y = 1 - (2 * n + 1) / count,
        turn = n * 2.399963,
        direction = new Vector3(
          Math.cos(turn) * Math.sqrt(1 - y * y),
          y,
          Math.sin(turn) * Math.sqrt(1 - y * y),
        );
      const light = (y < 0 ? back : horizon.value)
        .clone()
        .lerp(y < 0 ? back : zenith.value, 1 - Math.exp(-3.2 * Math.max(y, 0)));
      if (sun && y > 0)
        light.add(
          sunColour.value.clone().multiplyScalar(0.7 * Math.max(direction.dot(sun.direction), 0) ** 3),
        );
      SphericalHarmonics3.getBasisAt(direction, basis);
      this.harmonics.coefficients.forEach((sum, k) =>
        sum.addScaledVector(new Vector3(light.r, light.g, light.b), (basis[k] * 4 * Math.PI) / count),
      );
    }
  }

  /**
   * sun     direction to the sun and its colour, { direction: Vector3, colour: Color }; null: indoors
   * mirror  1: surfaces mirror the surroundings, so that metals are not black
   */
  set(sun, mirror) {
    const { sun: towards, sunColour, zenith, horizon, ground } = this.uniforms;
    this.#colours(sun ? SKY : ROOM_LIGHT);
    if (sun) {
      // a low sun is warm, and so is the horizon
      const low = 1 - Math.min(Math.max(sun.direction.y, 0) / 0.5, 1);
      horizon.value.lerp(new Color(0.95, 0.66, 0.42), 0.55 * low);
      sunColour.value.copy(sun.colour).multiply(new Color(1, 0.86 - 0.2 * low, 0.66 - 0.36 * low));
    }
    towards.value.set(0, 0, 0);
    this.uniforms.brightness.value = 1;
    this.colour.copy(zenith.value).lerp(horizon.value, 0.5);
    this.#findHarmonics(sun);
    this.environment?.dispose();
    this.environment = null;
    if (mirror) {
      const generator = new PMREMGenerator(this.renderer);
      this.environment = generator.fromScene(this.scene, 0, 0.1, 100, { size: 64 });
      generator.dispose();
    }
    if (sun) towards.value.copy(sun.direction);
    else this.#colours(ROOM);
  }

  /** Light the scenes: each surface gets `radiance` times the colours of the sky and the ground. */
  shine(scenes, radiance) {
    for (const scene of scenes) {
      let light = scene.children.find((child) => child.isLightProbe);
      if (!light) scene.add((light = new LightProbe()));
      light.sh.copy(this.harmonics);
      light.intensity = this.environment ? 0 : radiance;
      scene.environment = this.environment?.texture ?? null;
      scene.environmentIntensity = radiance;
    }
  }

  /** Draw it, behind all else.   brightness  what its white is in linear light, before tone mapping; 0: colours as they are shown */
  render(camera, brightness) {
    this.uniforms.brightness.value = brightness || 1;
    this.renderer.render(this.scene, camera);
  }
}
