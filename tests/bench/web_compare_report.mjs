// The page of make web-compare, of its JSON.
// SPDX-License-Identifier: GPL-3.0-or-later

const bytes = (n) => (n === 0 ? '0' : n < 1024 ** 2 ? `${(n / 1024).toFixed(0)} KiB` : `${(n / 1024 ** 2).toFixed(1)} MiB`);
const percent = (x) => `${(100 * x).toPrecision(3)} %`;

const image = (file) => `<a href="${file}"><img src="${file}"></a>`;
const table = (head, rows) =>
  `<table><tr>${head.map((text) => `<th>${text}`).join('')}\n${rows.map((cells) => `<tr><th>${cells.join('<td>')}`).join('\n')}</table>`;
const costs = (w) => [bytes(w.gpu_bytes), bytes(w.download_bytes), w.draw_calls, w.drawn_triangles];
const COSTS = ['on the GPU', 'download', 'draw calls', 'triangles'];

const section = (s) => `<h2>${s.name}</h2>\n${s.skipped ? `<p>Left out: ${s.skipped}.` : `<p>${s.triangles} triangles;
${s.pixels} pixels face the sun, and rays reach it from ${percent(s.lit)} of them. Truth: ${image(s.truth)}
${table(['way', 'mean error', 'wrong pixels', 'shimmer', ...COSTS, 'light; error: red too dark, blue too light'], s.ways.map((w) => (w.impossible
    ? [w.way, w.impossible]
    : [w.way, percent(w.mean_error), percent(w.wrong), w.shimmer ? percent(w.shimmer) : 0, ...costs(w), image(w.picture) + image(w.difference)])))}`}`;

const lamps = (s) => `<h2>A room with ${s.lamps} lamps</h2>
<p>${s.triangles} triangles. Error is the mean difference from the sum of the light of all lamps that rays reach, as a share of
its mean. Truth: ${image(s.truth)}
${table(['way', 'error', ...COSTS, 'light'], s.ways.map((w) => [w.way, percent(w.error), ...costs(w), image(w.picture)]))}`;

const fog = (s) => `<h2>God rays in a street of the city</h2>
<p>The share of each eye ray's airlight that the sun lights: by marching over a live map of 2048 x 2048, and by the lit
intervals in the file (FogPass), against 256 rays from each eye ray. GodraysNode of three.js, without its blur, and FogNode are drawn by
WebGPURenderer; GodraysNode dims no light on its way to the eye, and so does its truth. Time is that of a frame by that of 128 steps, in one run of
a software renderer: it says nothing about graphics cards. Truth: ${image(s.truth)}
${table(['way', 'mean error', 'largest error', 'time', 'light'], s.ways.map((w) => (
    [w.way, percent(w.mean_error), percent(w.largest_error), w.time.toPrecision(2), image(w.picture)])))}`;

const STYLE = `body { font: 15px system-ui; margin: 2em; max-width: 90em }
td, th { padding: .2em .7em; text-align: right; border-top: 1px solid #ccc }
th:first-child { text-align: left }
td:last-child { white-space: nowrap }
img { width: 240px; vertical-align: middle; margin: 2px }`;

export const pageOf = (report) => `<!doctype html><meta charset="utf-8"><title>Shadows of three.js, lightmaps and vxs</title>
<style>${STYLE}</style>
<h1>Shadows of three.js, lightmaps and vxs, against ray tracing</h1>
<p>${report.size_px.join(' x ')} pixels; surfaces white and matt. Each pixel's share of light is compared with a ray from its
surface to the light. <b>Mean error</b> is that of the share, <b>wrong</b> pixels are off by more than a half. <b>Shimmer</b> is
the mean change of a pixel when the camera that cascades follow makes a step of 7 cm and 0.4 degrees. Bytes on the GPU are those
of textures for shadows, with the colour buffer that three.js gives each live map, and of a lightmap's texture coordinates; draw
calls and triangles are those of a frame, shadow passes included. Maps that three.js renders once, with autoUpdate off, cost no
draw calls later. Maps of three.js, and depths of vxs in its slots, have the best of five normal biases.
${report.scenes.map(section).join('\n')}
${report.lamps ? lamps(report.lamps) : ''}${report.fog ? fog(report.fog) : ''}`;
