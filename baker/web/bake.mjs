// SPDX-License-Identifier: GPL-3.0-or-later
// bake(): the command, on files in memory, in a worker of a browser or of Node. bake.d.ts has its contract.

const INTERVAL_MS = 100;
let ownModule;

export class BakeError extends Error {
  constructor(message, status, messages) {
    super(message);
    this.name = 'BakeError';
    this.status = status;
    this.messages = messages;
  }
}

/** Options of the command in camelCase: { lights: 2, ifChanged: true } is --lights 2 --if-changed. */
function argumentsOf(options) {
  return Object.entries(options).flatMap(([name, value]) => {
    const option = `--${name.replace(/[A-Z]/g, (letter) => `-${letter.toLowerCase()}`)}`;
    return [value].flat().flatMap((one) => (one === true ? option : one === false || one === undefined ? [] : [option, String(one)]));
  });
}

/** The bytes of the package's own WebAssembly under Node, which has no fetch of files. */
async function readOwn(url) {
  const { readFile } = await import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:fs/promises');
  return readFile(url);
}

async function compile(source) {
  if (source instanceof WebAssembly.Module) return source;
  if (ArrayBuffer.isView(source) || source instanceof ArrayBuffer) return WebAssembly.compile(source);
  const url = source ?? new URL('./vxs.wasm', import.meta.url);
  if (url instanceof URL && url.protocol === 'file:' && typeof process === 'object') return WebAssembly.compile(await readOwn(url));
  const response = url instanceof Response ? url : await fetch(url);
  if (!response.ok) throw new BakeError(`${response.url}: ${response.status} ${response.statusText}`, 3, '');
  return WebAssembly.compile(await response.arrayBuffer());
}

/** A worker with the few functions that both kinds have: post, on('message' | 'error'), end. */
async function startWorker() {
  if (typeof Worker === 'function') {
    const worker = new Worker(new URL('./bake_worker.mjs', import.meta.url), { type: 'module' });
    return {
      post: (message) => worker.postMessage(message),
      onMessage: (call) => worker.addEventListener('message', (event) => call(event.data)),
      onError: (call) => worker.addEventListener('error', (event) => call(new Error(event.message || 'the worker cannot be loaded'))),
      end: () => worker.terminate(),
    };
  }
  const threads = await import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:worker_threads');
  const worker = new threads.Worker(new URL('./bake_worker.mjs', import.meta.url), { resourceLimits: { stackSizeMb: 8 } });
  return {
    post: (message) => worker.postMessage(message),
    onMessage: (call) => worker.on('message', call),
    onError: (call) => worker.on('error', call),
    end: () => worker.terminate(),
  };
}

/** Runs the command in a worker, and ends the worker. */
async function runInWorker(request, onProgress, signal) {
  const worker = await startWorker();
  let abort;
  let shownAt = -Infinity;
  try {
    return await new Promise((resolve, reject) => {
      abort = () => reject(signal.reason);
      signal?.addEventListener('abort', abort);
      signal?.throwIfAborted();
      worker.onError(reject);
      worker.onMessage((message) => {
        if (!message.progress) resolve(message);
        else if (performance.now() - shownAt >= INTERVAL_MS) {
          shownAt = performance.now();
          onProgress(message.progress);
        }
      });
      worker.post(request);
    });
  } finally {
    signal?.removeEventListener('abort', abort);
    worker.end();
  }
}

export async function bake(glb, options = {}, { onProgress, signal, wasm, files } = {}) {
  signal?.throwIfAborted();
  const module = await (wasm ? compile(wasm) : (ownModule ??= compile()));
  const request = {
    module,
    args: ['bake', 'scene.glb', '-o', 'scene.vxs', '--json', 'report.json', ...argumentsOf(options)],
    files: { ...files, 'scene.glb': glb },
    results: ['scene.vxs', 'report.json'],
    progress: Boolean(onProgress),
  };
  const { status, output, messages, results } = await runInWorker(request, onProgress, signal);
  const [vxs, report] = results;
  if (status !== 0 || !vxs) {
    const last = messages.trimEnd().split('\n').at(-1) || `exit status ${status}`;
    throw new BakeError(last.replace(/^vxs: error: /, ''), status, messages);
  }
  return { vxs, report: JSON.parse(new TextDecoder().decode(report)), summary: output, messages };
}
