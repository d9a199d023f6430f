// A baked lightmap of a soup of triangles in so many bytes: charts of triangles whose normals are alike, packed on
// shelves, one byte a texel. The caller traces the rays.
// SPDX-License-Identifier: GPL-3.0-or-later

const ALIKE = 0.9; // cosine between the normal of a chart and those of its triangles
const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (a) => a.map((x) => x / (Math.hypot(...a) || 1));

/** Charts: { triangles, corners: [2 * 3] of each in metres from the chart's corner, wide, high }. */
function chartsOf(soup) {
  const count = soup.length / 9, corner = (t, k) => Array.from(soup.subarray(9 * t + 3 * k, 9 * t + 3 * k + 3));
  const edge = (t, k) => sub(corner(t, k), corner(t, 0));
  const normals = Array.from({ length: count }, (_, t) => unit(cross(edge(t, 1), edge(t, 2))));
  const edges = new Map(), keyOf = (a, b) => (a < b ? `${a}|${b}` : `${b}|${a}`), ofTriangle = [];
  for (let t = 0; t < count; t++) {
    const c = [0, 1, 2].map((k) => corner(t, k).join());
    ofTriangle.push([0, 1, 2].map((k) => keyOf(c[k], c[(k + 1) % 3])));
    for (const key of ofTriangle[t]) edges.has(key) ? edges.get(key).push(t) : edges.set(key, [t]);
  }
  const used = new Uint8Array(count), charts = [];
  for (let seed = 0; seed < count; seed++) {
    if (used[seed] || !dot(normals[seed], normals[seed])) continue;
    const normal = normals[seed], list = [seed];
    used[seed] = 1;
    for (let n = 0; n < list.length; n++)
      for (const key of ofTriangle[list[n]])
        for (const other of edges.get(key))
          if (!used[other] && dot(normals[other], normal) > ALIKE) used[other] = list.push(other);
    const u = unit(edge(seed, 1)), v = cross(normal, u);
    const flat = list.map((t) => [0, 1, 2].flatMap((k) => [dot(corner(t, k), u), dot(corner(t, k), v)]));
    const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
    for (const f of flat)
      f.forEach((x, n) => { low[n % 2] = Math.min(low[n % 2], x); high[n % 2] = Math.max(high[n % 2], x); });
    charts.push({
      triangles: list, normals: list.map((t) => normals[t]), corners: flat.map((f) => f.map((x, n) => x - low[n % 2])),
      wide: high[0] - low[0], high: high[1] - low[1],
    });
  }
  return charts;
}

/**
 * Place charts at so many texels a metre; false if they need more than side x side. Filters read no texel of another
 * chart.
 */
function pack(charts, scale, side) {
  let x = 0, y = 0, shelf = 0;
  for (const chart of charts) {
    chart.size = [chart.wide, chart.high].map((metres) => Math.ceil(metres * scale) + 1);
    if (chart.size[0] > side) return false;
  }
  for (const chart of [...charts].sort((a, b) => b.size[1] - a.size[1])) {
    if (x + chart.size[0] > side) [x, y, shelf] = [0, y + shelf, 0];
    shelf = Math.max(shelf, chart.size[1]);
    chart.at = [x, y];
    x += chart.size[0];
    if (y + shelf > side) return false;
  }
  return true;
}

/**
 * soup   Float32Array [9 * triangles];   bytes  of the texture
 * trace  (points [6 * count]: position, normal) => share of light at each
 * Returns { side, texels, positions, uvs, metres: of a texel }: one vertex for each corner.
 */
export function lightmapOf(soup, bytes, trace) {
  const side = Math.floor(Math.sqrt(bytes)), charts = chartsOf(soup);
  let low = 0, high = 1000;
  if (!pack(charts, low, side)) return null; // not a texel for each chart
  for (let n = 0; n < 40; n++) {
    const middle = n ? (low + high) / 2 : 1;
    if (pack(charts, middle, side)) low = middle;
    else high = middle;
  }
  pack(charts, low, side);
  const scale = low, RAYS = 4, best = new Float32Array(side * side).fill(-Infinity), where = new Array(side * side);
  const uvs = new Uint16Array(soup.length / 9 * 6), positions = soup;
  for (const { triangles, corners, normals, at, size } of charts)
    triangles.forEach((t, n) => {
      const c = corners[n].map((x) => x * scale), [ax, ay, bx, by, cx, cy] = c, area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
      for (let k = 0; k < 6; k++) uvs[6 * t + k] = Math.round((65535 * (at[k % 2] + 0.5 + c[k])) / side);
      if (!area) return;
      const from = (axis) => Math.max(0, Math.floor(Math.min(c[axis], c[2 + axis], c[4 + axis])) - 1);
      const to = (axis) => Math.min(size[axis] - 1, Math.ceil(Math.max(c[axis], c[2 + axis], c[4 + axis])) + 1);
      for (let y = from(1); y <= to(1); y++)
        for (let x = from(0); x <= to(0); x++) {
          const weights = (px, py) => {
            const b = ((px - ax) * (cy - ay) - (py - ay) * (cx - ax)) / area;
            const g = ((bx - ax) * (py - ay) - (by - ay) * (px - ax)) / area;
            return [1 - b - g, b, g];
          };
          const inside = Math.min(...weights(x, y)), texel = at[0] + x + side * (at[1] + y);
          if (inside <= best[texel]) continue;
          best[texel] = inside;
          where[texel] = Array.from({ length: RAYS }, (_, r) => {
            const w = weights(x + (r % 2) / 2 - 0.25, y + (r >> 1) / 2 - 0.25).map((b) => Math.max(b, 0));
            const along = (axis) => w.reduce((sum, b, k) => sum + b * soup[9 * t + 3 * k + axis], 0) / (w[0] + w[1] + w[2]);
            return [along(0), along(1), along(2), ...normals[n]];
          });
        }
    });
  const filled = where.flatMap((points, texel) => (points ? [texel] : []));
  const lit = trace(filled.flatMap((texel) => where[texel].flat()));
  const texels = new Uint8Array(side * side);
  filled.forEach((texel, n) => {
    let sum = 0;
    for (let r = 0; r < RAYS; r++) sum += lit[RAYS * n + r];
    texels[texel] = Math.round((255 * sum) / RAYS);
  });
  return { side, texels, positions, uvs, metres: 1 / scale };
}
