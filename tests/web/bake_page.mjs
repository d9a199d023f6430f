// What tests of bake() run in a page of Chromium.
// SPDX-License-Identifier: GPL-3.0-or-later
import { BakeError, bake } from '/vxs/baker/bake.mjs';

const fetchBytes = async (url) => new Uint8Array(await (await fetch(url)).arrayBuffer());
const base64 = (bytes) => btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(''));

let workers = 0;
globalThis.Worker = class extends Worker {
  constructor(...parameters) {
    super(...parameters);
    workers++;
  }
};

export async function bakeScene({ url, options, settings }) {
  const progress = [];
  workers = 0;
  const glb = await fetchBytes(url);
  const result = await bake(glb, options, { ...settings, onProgress: (p) => progress.push(p) });
  const modules = performance.getEntriesByType('resource').map(({ name }) => name.split('/').at(-1)).filter((name) => name.endsWith('.wasm'));
  const { report, messages, summary } = result;
  return { vxs: base64(result.vxs), kept: glb.length, report, messages, summary, progress, workers, modules };
}

export async function failure({ url, options, settings }) {
  try {
    await bake(url ? await fetchBytes(url) : new Uint8Array(4), options, settings);
    return null;
  } catch (error) {
    return { isBakeError: error instanceof BakeError, name: error.name, message: error.message, status: error.status };
  }
}

/** Aborts a bake that would take minutes, while the page itself goes on. */
export async function aborted({ url, options }) {
  const glb = await fetchBytes(url);
  const controller = new AbortController();
  let ticks = 0;
  const ticking = setInterval(() => ticks++, 10);
  const start = performance.now();
  setTimeout(() => controller.abort(), 400);
  const name = await bake(glb, options, { signal: controller.signal }).then(() => 'it ended', (error) => error.name);
  clearInterval(ticking);
  return { name, ticks, ms: performance.now() - start };
}
