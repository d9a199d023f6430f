// SPDX-License-Identifier: GPL-3.0-or-later
// The worker of bake(): runs the command once, on files in memory.
import { MemoryFiles } from './files_memory.mjs';
import { failureOf, runCommand } from './host.mjs';

function run(port, { module, memory, threads, args, files, results, progress }) {
  const decoders = [undefined, new TextDecoder(), new TextDecoder()];
  const printed = ['', '', ''];
  const kept = new MemoryFiles(files, (fd, bytes) => (printed[fd] += decoders[fd].decode(bytes, { stream: true })));
  let status;
  try {
    status = runCommand(module, {
      args,
      env: {},
      files: kept,
      system: {
        process: 1,
        processors: 1,
        availableBytes: () => Infinity,
        progress: progress && ((share, doing) => port.postMessage({ progress: { share, doing } })),
      },
      memory,
      startThreads: memory && (() => port.postMessage({ lent: { module, memory, threads } })),
    });
  } catch (error) {
    const failure = failureOf(error);
    status = failure.status;
    printed[2] += failure.messages;
  }
  return { status, output: printed[1], messages: printed[2], results: results.map((name) => kept.bytes(name)?.slice()) };
}

function answer(port, request) {
  const done = run(port, request);
  port.postMessage(done, done.results.filter(Boolean).map((bytes) => bytes.buffer));
}

// a browser delivers messages once the module has run: it listens before it awaits anything
if (typeof WorkerGlobalScope !== 'undefined')
  globalThis.addEventListener('message', (event) => answer(globalThis, event.data), { once: true });
else
  import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:worker_threads').then(({ parentPort }) =>
    parentPort.once('message', (request) => answer(parentPort, request)));
