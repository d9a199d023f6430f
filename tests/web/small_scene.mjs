// A small scene as GLB: boxes and lights.
// SPDX-License-Identifier: GPL-3.0-or-later

const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7];
const FACES = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/**
 * boxes   [[x0, y0, z0, x1, y1, z1]], one mesh;   lights  [{ type, name, position, towards, ...KHR_lights_punctual }]
 * change  a function that may change the JSON;   extra  bytes of one more buffer view, 2
 */
export function glbOf(boxes, lights, change = () => {}, extra = Buffer.alloc(0)) {
  const positions = boxes.flatMap((box) => CORNERS.flatMap((c) => [0, 1, 2].map((axis) => box[axis + 3 * ((c >> axis) & 1)])));
  const indices = boxes.flatMap((_, n) => FACES.flatMap(([a, b, c, d]) => [a, b, c, a, c, d].map((v) => 8 * n + v)));
  const bytes = Buffer.concat([Buffer.from(Float32Array.from(positions).buffer), Buffer.from(Uint32Array.from(indices).buffer), extra, Buffer.alloc(-extra.length & 3)]);
  const axis = (n, of) => of(...positions.filter((_, k) => k % 3 === n));
  const json = {
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0, ...lights.map((_, n) => n + 1)] }],
    extensionsUsed: ['KHR_lights_punctual'],
    extensions: { KHR_lights_punctual: { lights: lights.map(({ position, rotation, ...light }) => light) } },
    nodes: [{ mesh: 0, name: 'boxes' }, ...lights.map(({ name, position, rotation }, n) => ({
      name, translation: position, ...(rotation && { rotation }), extensions: { KHR_lights_punctual: { light: n } },
    }))],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, type: 'VEC3', count: positions.length / 3, min: [0, 1, 2].map((n) => axis(n, Math.min)), max: [0, 1, 2].map((n) => axis(n, Math.max)) },
      { bufferView: 1, componentType: 5125, type: 'SCALAR', count: indices.length },
    ],
    bufferViews: [{ buffer: 0, byteLength: 4 * positions.length }, { buffer: 0, byteOffset: 4 * positions.length, byteLength: 4 * indices.length },
      ...(extra.length ? [{ buffer: 0, byteOffset: 4 * (positions.length + indices.length), byteLength: extra.length }] : [])],
    buffers: [{ byteLength: bytes.length }],
  };
  change(json);
  const text = Buffer.from(JSON.stringify(json)), padded = Buffer.concat([text, Buffer.alloc(-text.length & 3, 32)]);
  const head = Buffer.alloc(12), chunk = (length, kind) => Buffer.from(Uint32Array.of(length, kind).buffer);
  head.writeUInt32LE(0x46546c67, 0);
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(28 + padded.length + bytes.length, 8);
  return Buffer.concat([head, chunk(padded.length, 0x4e4f534a), padded, chunk(bytes.length, 0x004e4942), bytes]);
}

/** Pillars on a floor of 16 x 16 m, and a sun, a spot and a lamp. */
export const pillars = (change, extra) => glbOf(
  [[-8, -0.5, -8, 8, 0, 8], [-3, 0, -2, -2, 4, -1], [1, 0, 1, 2, 3, 2], [2, 0, -4, 3, 5, -3], [-1, 2, 3, 3, 2.4, 4]],
  [
    { type: 'directional', name: 'sun', position: [0, 10, 0], rotation: [-0.397, 0.31, 0.1445, 0.8517], intensity: 2 },
    { type: 'spot', name: 'spot', position: [-6, 6, 5], rotation: [-0.3, -0.35, -0.12, 0.88], intensity: 300, range: 30, spot: { innerConeAngle: 0.4, outerConeAngle: 0.6 } },
    { type: 'point', name: 'lamp', position: [0, 2.5, 0], intensity: 20, range: 25 },
  ].map(({ rotation, ...light }) => ({ ...light, ...(rotation && { rotation: unit(rotation) }) })), change, extra);

const unit = (v) => v.map((x) => x / Math.hypot(...v));

/** A hall of 165 lamps between pillars. */
export const hall = () => glbOf(
  [[-16, -0.5, -12, 16, 0, 12], ...Array.from({ length: 12 }, (_, n) => [-14 + 5 * (n % 6), 0, n < 6 ? -5 : 4, -13 + 5 * (n % 6), 4, n < 6 ? -4 : 5])],
  Array.from({ length: 165 }, (_, n) => ({
    type: 'point', name: `lamp ${n}`, intensity: 3, range: 5, color: [1, 0.5 + 0.5 * (n % 2), 0.6],
    position: [-15 + 2.1 * (n % 15), 0.6 + 0.7 * (n % 3), -10.5 + 2.1 * Math.floor(n / 15)],
  })));
