// SPDX-License-Identifier: GPL-3.0-or-later
// The worker of bake(): runs the command once, on files in memory.
import { MemoryFiles } from './files_memory.mjs';
import { runCommand } from './host.mjs';

const isNode = typeof WorkerGlobalScope === 'undefined';
const port = isNode ? (await import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:worker_threads')).parentPort : globalThis;
const OUT_OF_MEMORY = 6;
const CRASHED = 134;

function run({ module, args, files, results, progress }) {
  const decoders = [undefined, new TextDecoder(), new TextDecoder()];
  const printed = ['', '', ''];
  const memory = new MemoryFiles(files, (fd, bytes) => (printed[fd] += decoders[fd].decode(bytes, { stream: true })));
  let status;
  try {
    status = runCommand(module, {
      args,
      env: {},
      files: memory,
      system: {
        process: 1,
        processors: 1,
        availableBytes: () => Infinity,
        progress: progress && ((share, doing) => port.postMessage({ progress: { share, doing } })),
      },
    });
  } catch (error) {
    status = error instanceof RangeError ? OUT_OF_MEMORY : CRASHED;
    printed[2] += `vxs: error: ${status === OUT_OF_MEMORY ? 'out of memory' : error.message}\n`;
  }
  return { status, output: printed[1], messages: printed[2], results: results.map((name) => memory.bytes(name)?.slice()) };
}

function answer(request) {
  const done = run(request);
  port.postMessage(done, done.results.filter(Boolean).map((bytes) => bytes.buffer));
}

if (isNode) port.once('message', answer);
else port.addEventListener('message', (event) => answer(event.data), { once: true });
