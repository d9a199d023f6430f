// SPDX-License-Identifier: GPL-3.0-or-later
// bake(): the command, on files in memory, in a worker of a browser or of Node. bake.d.ts has its contract.

import { needsMemory, sharedMemory } from './host.mjs';
import { startThreads, startWorker } from './workers.mjs';

const INTERVAL_MS = 100;
const ownModules = {};

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
  if (source instanceof URL && source.protocol === 'file:' && typeof process === 'object') return WebAssembly.compile(await readOwn(source));
  const response = source instanceof Response ? source : await fetch(source);
  if (!response.ok) throw new BakeError(`${response.url}: ${response.status} ${response.statusText}`, 3, '');
  return WebAssembly.compile(await response.arrayBuffer());
}

const lentMemory = () => (typeof SharedArrayBuffer === 'function' && globalThis.crossOriginIsolated !== false ? sharedMemory() : undefined);

/** The package's own module, and memory for it if it has threads. */
async function ownModule(threads) {
  const memory = threads > 1 ? lentMemory() : undefined;
  ownModules[Boolean(memory)] ??= compile(memory ? new URL('./vxs-threads.wasm', import.meta.url) : new URL('./vxs.wasm', import.meta.url));
  return { module: await ownModules[Boolean(memory)], memory };
}

async function givenModule(source) {
  const module = await compile(source);
  const memory = needsMemory(module) ? lentMemory() : undefined;
  if (needsMemory(module) && !memory) throw new BakeError('WebAssembly with threads needs a page that is cross-origin isolated', 3, '');
  return { module, memory };
}

const commandInBrowser = () => new Worker(new URL('./bake_worker.mjs', import.meta.url), { type: 'module' });

/** Runs the command in a worker, and ends the worker. */
async function runInWorker(request, onProgress, signal) {
  const worker = await startWorker(commandInBrowser, new URL('./bake_worker.mjs', import.meta.url));
  let endThreads = () => {};
  let abort;
  let shownAt = -Infinity;
  try {
    return await new Promise((resolve, reject) => {
      abort = () => reject(signal.reason);
      signal?.addEventListener('abort', abort);
      signal?.throwIfAborted();
      worker.onError(reject);
      worker.onMessage((message) => {
        if (message.lent) endThreads = startThreads(message.lent, ({ status, messages }) => resolve({ status, messages, results: [] }));
        else if (!message.progress) resolve(message);
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
    endThreads();
  }
}

export async function bake(glb, options = {}, { onProgress, signal, wasm, files } = {}) {
  signal?.throwIfAborted();
  const threads = Number(options.threads) || 1;
  const request = {
    ...(await (wasm ? givenModule(wasm) : ownModule(threads))),
    threads,
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
