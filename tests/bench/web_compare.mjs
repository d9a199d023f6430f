// make web-compare: shadows of three.js, of a lightmap and of vxs on the same pixels, held against ray tracing (vxs truth): a page with
// pictures, and JSON.
//
//     node tests/bench/web_compare.mjs -o FOLDER [--only SCENE] [--size WxH]
//     node tests/bench/web_compare.mjs -o FOLDER --level FILE.glb --sun X,Y,Z --eye X,Y,Z --target X,Y,Z [--fov DEGREES] [--size WxH]
//
// VXS: the native command. VXS_PACKAGE: the package of make web. VXS_SCENES: shared scenes; without them there is no Sponza.
// No times: pictures come from a software renderer, which says nothing about a graphics card. Fog is compared at the steps that a
// march needs for the same error.
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
const vxs = (command, input) => execFileSync(process.env.VXS, command, { input, cwd: folder, maxBuffer: 2 ** 31, stdio: ['pipe', 'pipe', 'ignore'] });
const numbers = (name, fallback, separator = ',') => argument(name)?.split(separator).map(Number) ?? fallback;
const PAGE = '/bench/web_compare_page.mjs', SIZE = numbers('--size', [480, 270], 'x'), level = argument('--level');

const SIDES = ['4096', '16384'];
const CITY = ['city', '--triangles', '100000'], SUN = [-0.5, -1, -0.3];
const SCENES = level ? {
  [path.basename(level)]: { level, file: 'level', sun: numbers('--sun', SUN), view: { eye: numbers('--eye'), target: numbers('--target'), fov: Number(argument('--fov') ?? 60) } },
} : {
  'city, from above': { make: CITY, file: 'city', sun: SUN, view: { eye: [150, 90, 150], target: [20, 0, 20] } },
  'city, in a street': { make: CITY, file: 'city', sun: SUN, view: { eye: [3, 2, 60], target: [6, 6, 0], fov: 60 } },
  Sponza: { shared: 'sponza.glb', file: 'sponza', sun: [0.2, -1, 0.25], view: { eye: [-7, 2, -0.3], target: [5, 3.2, -0.6], fov: 60 } },
};

const decode = (text, Type) => {
  const bytes = Buffer.from(text, 'base64');
  return new Type(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
};

/** Light at points with normals, [6 * count], by rays: 1 or 0 for each. Normals are turned to the sun. */
function traced(scene, points) {
  const { sun } = scene, out = [], PART = 1_000_000;
  for (let first = 0; first < points.length; first += 6 * PART) {
    const lines = [];
    for (let n = first; n < Math.min(points.length, first + 6 * PART); n += 6) {
      const turn = points[n + 3] * sun[0] + points[n + 4] * sun[1] + points[n + 5] * sun[2] > 0 ? -1 : 1;
      lines.push(`${points[n]} ${points[n + 1]} ${points[n + 2]} ${turn * points[n + 3]} ${turn * points[n + 4]} ${turn * points[n + 5]}`);
    }
    for (const line of vxs(['truth', `${scene.file}.glb`, ...scene.light], `${lines.join('\n')}\n`).toString().trim().split('\n')) out.push(Number(line));
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
  for (const side of SIDES) vxs(['bake', `${scene.file}.glb`, '-o', `${scene.file}.${side}.vxs`, '--resolution', side, ...scene.light, '--force', '--quiet']);
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
      url: `/files/${name}`, side: made.side, triangles: soup.length / 9, metres: made.metres, download: zlib.deflateSync(made.texels, { level: 9 }).length });
  }
  return lightmaps.get(name);
}

/** Errors against the truth over the pixels that face the sun. */
function errorsOf(lit, truth) {
  let sum = 0, wrong = 0, pixels = 0;
  truth.forEach((wanted, n) => {
    if (wanted === null) return;
    const off = Math.abs(lit[n] / 255 - wanted);
    pixels++;
    sum += off;
    if (off > 0.5) wrong++;
  });
  return { mean_error: sum / pixels, wrong: wrong / pixels };
}

/** Run a function of the page module in a page of its own. */
async function inPage(what, given) {
  const page = await openPage(browser, server);
  try {
    return await run(page, PAGE, what, given);
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
  const files = { glb: `/files/${scene.file}.glb`, vxs: Object.fromEntries(SIDES.map((side) => [side, `/files/${scene.file}.${side}.vxs`])) }, stage = { ...files, sun: scene.sun, view: scene.view, size: SIZE };
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
  const result = { name, triangles: null, pixels: at.length, lit: answers.reduce((a, b) => a + b, 0) / answers.length, truth: `${slug(name)}-truth.png`, ways: [] };
  await save(result.truth, grey((n) => 255 * truth[n]));

  const fileBytes = (way) => fs.statSync(path.join(folder, `${scene.file}.${/\d+/.exec(way)}.vxs`)).size;
  const soup = decode(await inPage('triangles', stage), Float32Array);
  result.triangles = soup.length / 9;
  let lightmap;
  for (const way of await run(pictures, PAGE, 'names')) {
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
    const best = errors.reduce((least, e, n) => (e.mean_error < errors[least].mean_error ? n : least), 0), file = `${slug(name)}-${slug(way)}`;
    await save(`${file}.png`, grey((n) => tries[best][n]));
    await save(`${file}-error.png`, truth.flatMap((wanted, n) => {
      const off = wanted === null ? 0 : tries[best][n] - 255 * wanted;
      return wanted === null ? [40, 40, 40] : [255 - Math.max(off, 0), 255 - Math.abs(off), 255 + Math.min(off, 0)];
    }), SIZE, 3);
    result.ways.push({
      way, ...errors[best], shimmer: got.change, gpu_bytes: got.bytes, draw_calls: got.calls, drawn_triangles: got.triangles, picture: `${file}.png`, difference: `${file}-error.png`,
      download_bytes: way.startsWith('vxs') ? fileBytes(way) : way.startsWith('lightmap') ? lightmap.download : 0, ...(way.startsWith('lightmap') && { texel_metres: lightmap.metres }),
    });
    console.log(name, JSON.stringify(result.ways.at(-1)));
  }
  return result;
}

/** The generated room with 165 lamps below its ceiling, which shine down. More than 16 live maps are more than WebGL binds. */
async function compareLamps() {
  vxs(['scene', 'room', '-o', 'room.glb', '--force', '--quiet']);
  const glb = fs.readFileSync(path.join(folder, 'room.glb')), length = glb.readUInt32LE(12), json = JSON.parse(glb.subarray(20, 20 + length).toString());
  const soup = decode(await inPage('triangles', { glb: '/files/room.glb', view: ROOM, size: [8, 8] }), Float32Array), low = [], high = [];
  for (let axis = 0; axis < 3; axis++) {
    const of = soup.filter((_, n) => n % 3 === axis);
    low.push(of.reduce((a, b) => Math.min(a, b)));
    high.push(of.reduce((a, b) => Math.max(a, b)));
  }
  const at = (axis, share) => low[axis] + share * (high[axis] - low[axis]);
  json.extensions.KHR_lights_punctual.lights = Array.from({ length: 165 }, (_, n) => (
    { name: `lamp${n}`, type: 'spot', intensity: 4, range: 8, color: [1, 1, 1], spot: { innerConeAngle: 0.5, outerConeAngle: 0.9 } }));
  json.nodes = json.nodes.filter((node) => !node.extensions?.KHR_lights_punctual);
  const first = json.nodes.length;
  json.extensions.KHR_lights_punctual.lights.forEach((light, n) => json.nodes.push({
    name: light.name, rotation: [-Math.SQRT1_2, 0, 0, Math.SQRT1_2], extensions: { KHR_lights_punctual: { light: n } },
    translation: [at(0, (0.7 + (n % 15)) / 15.4), at(1, 0.8), at(2, (0.7 + Math.floor(n / 15)) / 11.4)],
  }));
  json.scenes = [{ nodes: json.nodes.map((_, n) => n) }];
  const text = Buffer.from(JSON.stringify(json)), head = Buffer.alloc(20), rest = glb.subarray(20 + length), body = Buffer.concat([text, Buffer.alloc(-text.length & 3, 32)]);
  glb.copy(head, 0, 0, 20);
  head.writeUInt32LE(20 + body.length + rest.length, 8);
  head.writeUInt32LE(body.length, 12);
  fs.writeFileSync(path.join(folder, 'lamps.glb'), Buffer.concat([head, body, rest]));
  vxs(['bake', 'lamps.glb', '-o', 'lamps.vxs', '--resolution', '256', '--force', '--quiet']);

  const stage = { glb: '/files/lamps.glb', vxs: '/files/lamps.vxs', view: ROOM, size: SIZE }, pixels = decode(await inPage('surfaces', stage), Float32Array);
  const lines = [], count = pixels.length / 8;
  for (let n = 0; n < count; n++) lines.push(Array.from(pixels.subarray(8 * n, 8 * n + 7).filter((_, k) => k !== 3)).map((x, k) => (k === 3 || x || k > 3 ? x : 0)).join(' '));
  const lit = Buffer.alloc(count * 165), seen = Array.from({ length: count }, (_, n) => n).filter((n) => pixels[8 * n + 3] > 0);
  const answers = vxs(['truth', 'lamps.glb'], `${seen.map((n) => lines[n]).join('\n')}\n`).toString().trim().split('\n');
  answers.forEach((line, k) => line.split(' ').forEach((x, n) => { lit[seen[k] * 165 + n] = x === '1' ? 1 : 0; }));
  fs.writeFileSync(path.join(folder, 'lamps.lit'), lit);
  const result = await inPage('lamps', { ...stage, lit: '/files/lamps.lit', live: 5 });
  result.truth = await save('lamps-truth.png', Buffer.from(result.truth, 'base64'));
  for (const way of result.ways) {
    way.picture = await save(`lamps-${slug(way.way)}.png`, Buffer.from(way.picture, 'base64'));
    way.download_bytes = way.way.startsWith('vxs') ? fs.statSync(path.join(folder, 'lamps.vxs')).size : 0;
    console.log('lamps', JSON.stringify(way));
  }
  return { triangles: soup.length / 9, ...result };
}

/** God rays in a street of the city: the share of each eye ray's airlight that is lit. */
async function compareFog() {
  const scene = SCENES['city, in a street'], size = [96, 54], sigma = 0.01, far = 150, RAYS = 256, view = { ...scene.view, eye: [3, 2, 60], target: [-6, 12, 0] };
  prepare(scene);
  const stage = { glb: '/files/city.glb', vxs: '/files/city.4096.vxs', sun: scene.sun, view, size };
  const { lit, ratio } = await inPage('fog', { ...stage, sigma, far, steps: [16, 32, 64, 128, 256], times: 5 });
  const rays = decode(await inPage('rays', stage), Float32Array), lines = [];
  const metresOf = (n) => (rays[4 * n + 3] > 0 ? Math.min(rays[4 * n + 3], far) : far);
  for (let n = 0; n < size[0] * size[1]; n++)
    for (let k = 0; k < RAYS; k++) lines.push([0, 1, 2].map((axis) => view.eye[axis] + ((metresOf(n) * (k + 0.5)) / RAYS) * rays[4 * n + axis]).join(' '));
  const answers = vxs(['truth', 'city.glb', '--light', 'sun'], `${lines.join('\n')}\n`).toString().trim().split('\n').map(Number);
  const truth = Array.from({ length: size[0] * size[1] }, (_, n) => {
    let sum = 0, all = 0;
    for (let k = 0; k < RAYS; k++) {
      const weight = Math.exp((-sigma * metresOf(n) * (k + 0.5)) / RAYS);
      sum += weight * answers[RAYS * n + k];
      all += weight;
    }
    return sum / all;
  });
  const ways = [], grey = (values) => Uint8Array.from(values, (x) => Math.round(255 * Math.min(Math.max(x, 0), 1)));
  for (const [way, text] of Object.entries(lit)) {
    const got = decode(text, Float32Array), off = Array.from(got, (x, n) => Math.abs(x - truth[n]));
    ways.push({ way, mean_error: off.reduce((a, b) => a + b) / off.length, largest_error: off.reduce((a, b) => Math.max(a, b)), time: ratio[way], picture: await save(`fog-${slug(way)}.png`, grey(got), size) });
    console.log('fog', JSON.stringify(ways.at(-1)));
  }
  return { size_px: size, truth: await save('fog-truth.png', grey(truth), size), lit: truth.reduce((a, b) => a + b) / truth.length, ways };
}

const ROOM = { eye: [2.2, 1.7, 2.2], target: [-1, 0.6, -1], fov: 65 };
fs.mkdirSync(folder, { recursive: true });
const server = await serve(folder), browser = await launch(), pictures = await openPage(browser, server);
const report = { version: 1, size_px: SIZE, scenes: [] };
try {
  for (const [name, scene] of Object.entries(SCENES)) if (!only || name.includes(only)) report.scenes.push(await compareSun(name, scene));
  if (!level && (!only || only === 'lamps')) report.lamps = await compareLamps();
  if (!level && (!only || only === 'fog')) report.fog = await compareFog();
} finally {
  await browser.close();
  await server.close();
}
fs.writeFileSync(path.join(folder, 'compare.json'), `${JSON.stringify(report, null, 1)}\n`);
fs.writeFileSync(path.join(folder, 'index.html'), pageOf(report));
console.log(`wrote ${path.join(folder, 'index.html')}`);
