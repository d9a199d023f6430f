// make web-compare: shadows of three.js, of lightmaps and of vxs on the same pixels, held against ray tracing
// (vxs truth): a page with pictures, and JSON.
//
//     node tests/bench/web_compare.mjs -o FOLDER [--only SCENE] [--size WxH] [--ways REGEX]
//     node tests/bench/web_compare.mjs -o FOLDER --level FILE.glb --sun X,Y,Z --eye X,Y,Z --target X,Y,Z
//         [--fov DEGREES] [--size WxH] [--ways REGEX]
//
// VXS: the native command. VXS_PACKAGE: the package of make web. VXS_SCENES: shared scenes; without them there is no
// Sponza. Pictures come from a software renderer: its times say nothing about a graphics card.
// SPDX-License-Identifier: GPL-3.0-or-later
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import path from 'node:path';
import { fileURLToPath } from 'node:url';
import zlib from 'node:zlib';
import { launch, openPage, run, serve } from '../web/browser.mjs';
import { lightmapOf } from './web_compare_lightmap.mjs';
import { pageOf } from './web_compare_report.mjs';

const argument = (name) => (process.argv.includes(name) ? process.argv[process.argv.indexOf(name) + 1] : null);
const folder = path.resolve(argument('-o') ?? 'build/web/compare'), only = argument('--only');
const root = path.resolve(path.dirname(fileURLToPath(import.meta.url)), '../..');
const vxs = (command, input) =>
  execFileSync(process.env.VXS, command, { input, cwd: folder, maxBuffer: 2 ** 31, stdio: ['pipe', 'pipe', 'ignore'] }).toString();
/** Lines of answers to lines of points. */
const truthOf = (options, lines) => vxs(['truth', ...options], `${lines.join('\n')}\n`).trim().split('\n');
const sum = (values) => values.reduce((a, b) => a + b, 0);
const sizeOf = (name) => fs.statSync(path.join(folder, name)).size;
const numbers = (name, fallback, separator = ',') => argument(name)?.split(separator).map(Number) ?? fallback;
const PAGE = '/bench/web_compare_page.mjs', SIZE = numbers('--size', [480, 270], 'x'), level = argument('--level');
const ways = new RegExp(argument('--ways') ?? '.'); // a lightmap needs 'vxs N, 1 x 1', whose bytes it takes

const SIDES = ['4096', '16384'];
const CITY = ['city', '--triangles', '100000'], SUN = [-0.5, -1, -0.3];
const SCENES = level ? {
  [path.basename(level)]: {
    level, file: 'level', sun: numbers('--sun', SUN),
    view: { eye: numbers('--eye'), target: numbers('--target'), fov: Number(argument('--fov') ?? 60) },
  },
} : {
  'city, from above': { make: CITY, file: 'city', sun: SUN, view: { eye: [150, 90, 150], target: [20, 0, 20] } },
  'city, in a street': { make: CITY, file: 'city', sun: SUN, view: { eye: [3, 2, 60], target: [6, 6, 0], fov: 60 } },
  Sponza: {
    shared: 'sponza.glb', file: 'sponza', sun: [0.2, -1, 0.25], view: { eye: [-7, 2, -0.3], target: [5, 3.2, -0.6], fov: 60 },
  },
};

const decode = (text, Type) => {
  const bytes = Buffer.from(text, 'base64');
  return new Type(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};

const bake = (from, to, ...options) => vxs(['bake', from, '-o', to, '--force', '--quiet', ...options]);

/** Light at points with normals, [6 * count], by rays: 1 or 0 for each. Normals are turned to the sun. */
function traced(scene, points) {
  const { sun } = scene, out = [], PART = 1_000_000;
  for (let first = 0; first < points.length; first += 6 * PART) {
    const lines = [];
    for (let n = first; n < Math.min(points.length, first + 6 * PART); n += 6) {
      const turn = points[n + 3] * sun[0] + points[n + 4] * sun[1] + points[n + 5] * sun[2] > 0 ? -1 : 1;
      const [x, y, z, ...normal] = points.slice(n, n + 6);
      lines.push(`${x} ${y} ${z} ${normal.map((c) => turn * c).join(' ')}`);
    }
    for (const line of truthOf([`${scene.file}.glb`, ...scene.light], lines)) out.push(Number(line));
  }
  return out;
}

function prepare(scene) {
  if (!scene.make) {
    const from = scene.level ?? path.join(process.env.VXS_SCENES ?? path.join(root, '../shared/scenes'), 'real', scene.shared);
    if (!fs.existsSync(from)) return `${scene.shared ?? from} is not there: set VXS_SCENES`;
    fs.copyFileSync(from, path.join(folder, `${scene.file}.glb`));
    scene.light = ['--sun', scene.sun.join()];
  } else {
    vxs(['scene', ...scene.make, '-o', `${scene.file}.glb`, '--force', '--quiet']);
    scene.light = ['--light', 'sun'];
  }
  for (const side of SIDES)
    bake(`${scene.file}.glb`, `${scene.file}.${side}.vxs`, '--resolution', side, ...scene.light);
  return null;
}

const lightmaps = new Map();

/** A lightmap of that many bytes in files of the folder; null: there are more charts than texels. */
function lightmapFile(scene, soup, bytes) {
  const name = `${scene.file}.lightmap.${bytes}`;
  if (!lightmaps.has(name)) {
    const made = lightmapOf(soup, bytes, (points) => traced(scene, points));
    for (const what of made ? ['positions', 'uvs', 'texels'] : []) fs.writeFileSync(path.join(folder, `${name}.${what}`), made[what]);
    lightmaps.set(name, made && {
      url: `/files/${name}`, side: made.side, triangles: soup.length / 9, metres: made.metres,
      download: zlib.deflateSync(made.texels, { level: 9 }).length,
    });
  }
  return lightmaps.get(name);
}

/** Errors against the truth over the pixels that face the sun. */
function errorsOf(lit, truth) {
  let all = 0, wrong = 0, pixels = 0;
  truth.forEach((wanted, n) => {
    if (wanted === null) return;
    const off = Math.abs(lit[n] / 255 - wanted);
    pixels++;
    all += off;
    if (off > 0.5) wrong++;
  });
  return { mean_error: all / pixels, wrong: wrong / pixels };
}

/** Run a function of a page module in a page of its own. */
async function inPage(what, given, module = PAGE, kind = {}) {
  const page = await openPage(browser, server, kind);
  try {
    return await run(page, module, what, given);
  } finally {
    await page.close();
    if (page.faults.length) console.log(`${what}: ${page.faults.join('; ')}`);
  }
}

const slug = (text) => text.toLowerCase().replace(/[^a-z0-9]+/g, '-');
async function save(file, bytes, size = SIZE, channels = 1) {
  const png = await run(pictures, PAGE, 'picture', { bytes: Buffer.from(bytes).toString('base64'), size, channels });
  fs.writeFileSync(path.join(folder, file), Buffer.from(png, 'base64'));
  return file;
}

async function compareSun(name, scene) {
  const missing = prepare(scene);
  if (missing) return { name, skipped: missing };
  const stage = { glb: `/files/${scene.file}.glb`, sun: scene.sun, view: scene.view, size: SIZE };
  stage.vxs = Object.fromEntries(SIDES.map((side) => [side, `/files/${scene.file}.${side}.vxs`]));
  const pixels = decode(await inPage('surfaces', stage), Float32Array), points = [], at = [];
  let far = 0;
  for (let n = 0; n < pixels.length / 8; n++) {
    if (!(pixels[8 * n + 3] > 0)) continue;
    far = Math.max(far, pixels[8 * n + 3]);
    if (pixels[8 * n + 7] <= 1e-2) continue;
    at.push(n);
    points.push(...pixels.subarray(8 * n, 8 * n + 3), ...pixels.subarray(8 * n + 4, 8 * n + 7));
  }
  const answers = traced(scene, points), truth = new Array(pixels.length / 8).fill(null);
  at.forEach((n, k) => { truth[n] = answers[k]; });
  const grey = (lit) => truth.map((wanted, n) => (wanted === null ? 40 : lit(n)));
  const soup = decode(await inPage('triangles', stage), Float32Array);
  const result = { name, triangles: soup.length / 9, pixels: at.length, lit: sum(answers) / answers.length, ways: [] };
  result.truth = await save(`${slug(name)}-truth.png`, grey((n) => 255 * truth[n]));
  let lightmap;
  for (const way of await run(pictures, PAGE, 'names')) {
    if (!ways.test(way)) continue;
    if (way.startsWith('lightmap')) {
      const words = result.ways.find((w) => w.way === `${/vxs \d+$/.exec(way)[0]}, 1 x 1`).gpu_bytes;
      lightmap = lightmapFile(scene, soup, words);
      if (!lightmap) {
        result.ways.push({ way, impossible: `${words} bytes are fewer texels than there are charts` });
        continue;
      }
    }
    const got = await inPage('litPixels', { ...stage, way, far, lightmap });
    const tries = got.tries.map((text) => decode(text, Uint8Array)), errors = tries.map((lit) => errorsOf(lit, truth));
    const best = errors.indexOf(errors.reduce((least, e) => (e.mean_error < least.mean_error ? e : least)));
    const file = `${slug(name)}-${slug(way)}`, colours = truth.flatMap((wanted, n) => {
      const off = wanted === null ? 0 : tries[best][n] - 255 * wanted;
      return wanted === null ? [40, 40, 40] : [255 - Math.max(off, 0), 255 - Math.abs(off), 255 + Math.min(off, 0)];
    });
    const isLightmap = way.startsWith('lightmap'), baked = `${scene.file}.${/\d+/.exec(way)}.vxs`;
    result.ways.push({
      way, ...errors[best], ...(got.biases && { normal_bias_texels: got.biases[best] }), shimmer: got.change,
      gpu_bytes: got.bytes, draw_calls: got.calls, drawn_triangles: got.triangles,
      download_bytes: isLightmap ? lightmap.download : way.startsWith('vxs') ? sizeOf(baked) : 0,
      ...(isLightmap && { texel_metres: lightmap.metres }),
      picture: await save(`${file}.png`, grey((n) => tries[best][n])),
      difference: await save(`${file}-error.png`, colours, SIZE, 3),
    });
    console.log(name, JSON.stringify(result.ways.at(-1)));
  }
  return result;
}

/** A copy of a GLB, as bytes, whose lights are these: [{ light, translation }], all turned straight down. */
function withLamps(glb, lamps) {
  const length = glb.readUInt32LE(12), json = JSON.parse(glb.subarray(20, 20 + length).toString()), rest = glb.subarray(20 + length);
  json.extensions.KHR_lights_punctual.lights = lamps.map(({ light }) => light);
  json.nodes = json.nodes.filter((node) => !node.extensions?.KHR_lights_punctual).concat(lamps.map(({ light, translation }, n) => ({
    name: light.name, translation, rotation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2], extensions: { KHR_lights_punctual: { light: n } },
  })));
  json.scenes = [{ nodes: json.nodes.map((_, n) => n) }];
  const text = Buffer.from(JSON.stringify(json)), body = Buffer.concat([text, Buffer.alloc(-text.length & 3, 32)]);
  const head = Buffer.from(glb.subarray(0, 20));
  head.writeUInt32LE(20 + body.length + rest.length, 8);
  head.writeUInt32LE(body.length, 12);
  return Buffer.concat([head, body, rest]);
}

/** The generated room with 165 lamps below its ceiling, which shine down: more maps than WebGL binds. */
async function compareLamps() {
  const LAMPS = 165, ROOM = { eye: [2.2, 1.7, 2.2], target: [-1, 0.6, -1], fov: 65 };
  vxs(['scene', 'room', '-o', 'room.glb', '--force', '--quiet']);
  const soup = decode(await inPage('triangles', { glb: '/files/room.glb', view: ROOM, size: [8, 8] }), Float32Array);
  const at = (axis, share) => {
    const along = soup.filter((_, n) => n % 3 === axis), low = along.reduce((a, b) => Math.min(a, b));
    return low + share * (along.reduce((a, b) => Math.max(a, b)) - low);
  };
  const spot = { type: 'spot', intensity: 4, range: 8, color: [1, 1, 1], spot: { innerConeAngle: 0.5, outerConeAngle: 0.9 } };
  const lamps = Array.from({ length: LAMPS }, (_, n) => ({
    light: { name: `lamp${n}`, ...spot },
    translation: [at(0, (0.7 + (n % 15)) / 15.4), at(1, 0.8), at(2, (0.7 + Math.floor(n / 15)) / 11.4)],
  }));
  fs.writeFileSync(path.join(folder, 'lamps.glb'), withLamps(fs.readFileSync(path.join(folder, 'room.glb')), lamps));
  bake('lamps.glb', 'lamps.vxs', '--resolution', '256');

  const stage = { glb: '/files/lamps.glb', vxs: '/files/lamps.vxs', view: ROOM, size: SIZE };
  const pixels = decode(await inPage('surfaces', stage), Float32Array), seen = [];
  for (let n = 0; n < pixels.length / 8; n++) if (pixels[8 * n + 3] > 0) seen.push(n);
  const lines = seen.map((n) => [0, 1, 2, 4, 5, 6].map((k) => pixels[8 * n + k]).join(' '));
  const lit = Buffer.alloc((pixels.length / 8) * LAMPS);
  truthOf(['lamps.glb'], lines).forEach((line, k) => {
    line.split(' ').forEach((x, n) => { lit[seen[k] * LAMPS + n] = x === '1' ? 1 : 0; });
  });
  fs.writeFileSync(path.join(folder, 'lamps.lit'), lit);
  const result = await inPage('lamps', { ...stage, lit: '/files/lamps.lit', live: 5 });
  result.truth = await save('lamps-truth.png', Buffer.from(result.truth, 'base64'));
  for (const way of result.ways) {
    way.picture = await save(`lamps-${slug(way.way)}.png`, Buffer.from(way.picture, 'base64'));
    way.download_bytes = way.way.startsWith('vxs') ? sizeOf('lamps.vxs') : 0;
    console.log('lamps', JSON.stringify(way));
  }
  return { triangles: soup.length / 9, ...result };
}

/** God rays in a street of the city: the share of each eye ray's airlight that is lit. */
async function compareFog() {
  const scene = SCENES['city, in a street'], size = [192, 108], sigma = 0.01, far = 150, RAYS = 256;
  const view = { ...scene.view, target: [-6, 12, 0] };
  prepare(scene);
  const stage = { glb: '/files/city.glb', vxs: '/files/city.4096.vxs', sun: scene.sun, view, size };
  const fog = await inPage('fog', { ...stage, sigma, far, steps: [16, 32, 64, 128, 256], times: 9 });
  const rays = decode(await inPage('rays', stage), Float32Array), lines = [];
  const metresOf = (n) => (rays[4 * n + 3] > 0 ? Math.min(rays[4 * n + 3], far) : far);
  for (let n = 0; n < size[0] * size[1]; n++)
    for (let k = 0; k < RAYS; k++) {
      const t = (metresOf(n) * (k + 0.5)) / RAYS;
      lines.push([0, 1, 2].map((axis) => view.eye[axis] + t * rays[4 * n + axis]).join(' '));
    }
  const metres = Array.from({ length: size[0] * size[1] }, (_, n) => metresOf(n));
  const nodes = await inPage('fogNodes', { ...stage, sigma, far, times: 9, metres }, '/bench/web_compare_nodes.mjs', { webgpu: true });
  const answers = [], PART = 1_000_000;
  for (let n = 0; n < lines.length; n += PART) for (const lit of truthOf(['city.glb', ...scene.light], lines.slice(n, n + PART))) answers.push(Number(lit));
  const shares = (extinction) => metres.map((_, n) => {
    let lit = 0, all = 0;
    for (let k = 0; k < RAYS; k++) {
      const weight = Math.exp((-extinction * metres[n] * (k + 0.5)) / RAYS);
      lit += weight * answers[RAYS * n + k];
      all += weight;
    }
    return lit / all;
  }), truth = shares(sigma), even = shares(0); // GodraysNode dims no light on its way to the eye
  const ways = [], grey = (values) => Uint8Array.from(values, (x) => Math.round(255 * Math.min(Math.max(x, 0), 1)));
  for (const [way, text] of [...Object.entries(fog.lit), ...Object.entries(nodes.lit)]) {
    const wanted = way.includes('GodraysNode') ? even : truth, got = decode(text, Float32Array), off = Array.from(got, (x, n) => Math.abs(x - wanted[n]));
    ways.push({
      way, mean_error: sum(off) / off.length, largest_error: Math.max(...off), time: fog.ratio[way] ?? nodes.ratio[way],
      picture: await save(`fog-${slug(way)}.png`, grey(got), size),
    });
    console.log('fog', JSON.stringify(ways.at(-1)));
  }
  return { size_px: size, truth: await save('fog-truth.png', grey(truth), size), lit: sum(truth) / truth.length, ways };
}

fs.mkdirSync(folder, { recursive: true });
const server = await serve(folder), browser = await launch(), pictures = await openPage(browser, server);
const report = { version: 1, size_px: SIZE, scenes: [] };
try {
  for (const [name, scene] of Object.entries(SCENES))
    if (!only || name.includes(only)) report.scenes.push(await compareSun(name, scene));
  if (!level && (!only || only === 'lamps')) report.lamps = await compareLamps();
  if (!level && (!only || only === 'fog')) report.fog = await compareFog();
} finally {
  await browser.close();
  await server.close();
}
fs.writeFileSync(path.join(folder, 'compare.json'), `${JSON.stringify(report, null, 1)}\n`);
fs.writeFileSync(path.join(folder, 'index.html'), pageOf(report));
console.log(`wrote ${path.join(folder, 'index.html')}`);
