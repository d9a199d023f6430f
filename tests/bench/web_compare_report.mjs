// The page of make web-compare, of its JSON.
// SPDX-License-Identifier: GPL-3.0-or-later

const bytes = (n) => (n === 0 ? '0' : n < 1024 ** 2 ? `${(n / 1024).toFixed(0)} KiB` : `${(n / 1024 ** 2).toFixed(1)} MiB`);
const percent = (x) => `${(100 * x).toPrecision(3)} %`;

const row = (w) => (w.impossible ? `<tr><th>${w.way}<td colspan=8>${w.impossible}` : `<tr><th>${w.way}<td>${percent(w.mean_error)}<td>${percent(w.wrong)}<td>${w.shimmer ? percent(w.shimmer) : '0'}
<td>${bytes(w.gpu_bytes)}<td>${bytes(w.download_bytes)}<td>${w.draw_calls}<td>${w.drawn_triangles}<td><a href="${w.picture}"><img src="${w.picture}"></a><a href="${w.difference}"><img src="${w.difference}"></a>`);

const section = (s) => (s.skipped ? `<h2>${s.name}</h2><p>Left out: ${s.skipped}.` : `<h2>${s.name}</h2>
<p>${s.triangles} triangles; ${s.pixels} pixels face the sun, and rays reach it from ${percent(s.lit)} of them. Truth: <a href="${s.truth}"><img src="${s.truth}"></a>
<table><tr><th>way<th>mean error<th>wrong pixels<th>shimmer<th>on the GPU<th>download<th>draw calls<th>triangles<th>light; error: red too dark, blue too light
${s.ways.map(row).join('\n')}</table>`);

const lamps = (s) => `<h2>A room with ${s.lamps} lamps</h2>
<p>${s.triangles} triangles. Error is the mean difference from the sum of the light of all lamps that rays reach, as a share of its mean. Truth: <img src="${s.truth}">
<table><tr><th>way<th>error<th>on the GPU<th>download<th>draw calls<th>triangles<th>light
${s.ways.map((w) => `<tr><th>${w.way}<td>${percent(w.error)}<td>${bytes(w.gpu_bytes)}<td>${bytes(w.download_bytes)}<td>${w.draw_calls}<td>${w.drawn_triangles}<td><img src="${w.picture}">`).join('\n')}</table>`;

const fog = (s) => `<h2>God rays in a street of the city</h2>
<p>The share of each eye ray's airlight that the sun lights: by marching over a live map of 2048 x 2048, and by the lit intervals in the file (FogPass), against
256 rays from each eye ray. Time is that of a frame by that of intervals, in one run of a software renderer: no statement on graphics cards. Truth: <img src="${s.truth}">
<table><tr><th>way<th>mean error<th>largest error<th>time<th>light
${s.ways.map((w) => `<tr><th>${w.way}<td>${percent(w.mean_error)}<td>${percent(w.largest_error)}<td>${w.time.toPrecision(2)}<td><img src="${w.picture}">`).join('\n')}</table>`;

export const pageOf = (report) => `<!doctype html><meta charset="utf-8"><title>Shadows of three.js, lightmaps and vxs</title>
<style>body { font: 15px system-ui; margin: 2em; max-width: 90em } td:last-child { white-space: nowrap } td, th { padding: .2em .7em; text-align: right; border-top: 1px solid #ccc } th:first-child { text-align: left } img { width: 240px; vertical-align: middle; margin: 2px }</style>
<h1>Shadows of three.js, lightmaps and vxs, against ray tracing</h1>
<p>${report.size_px.join(' x ')} pixels; surfaces white and matt. Each pixel's share of light is compared with a ray from its surface to the light.
<b>Mean error</b> is that of the share, <b>wrong</b> pixels are off by more than a half. <b>Shimmer</b> is the mean change of a pixel when the camera that
cascades follow makes a step of 7 cm and 0.4 degrees. Bytes on the GPU are those of textures for shadows, with the colour buffer that three.js gives each
live map; draw calls and triangles are those of a frame, shadow passes included. Live maps have the best of five normal biases.
${report.scenes.map(section).join('\n')}
${report.lamps ? lamps(report.lamps) : ''}${report.fog ? fog(report.fog) : ''}`;
