// SPDX-License-Identifier: GPL-3.0-or-later
// A thread of the command: workers.mjs starts it. It posts a message only when the command must end.
import { failureOf, runThread } from './host.mjs';

async function run(port, { module, memory, number, isOfNode }) {
  const system = isOfNode ? await import(/* @vite-ignore */ /* webpackIgnore: true */ './memory_node.mjs') : { availableBytes: () => Infinity };
  try {
    port.postMessage({ status: runThread(module, memory, number, system.availableBytes), messages: '' });
  } catch (error) {
    port.postMessage(failureOf(error));
  }
}

if (typeof WorkerGlobalScope !== 'undefined')
  globalThis.addEventListener('message', (event) => run(globalThis, event.data), { once: true });
else
  import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:worker_threads').then(({ parentPort }) =>
    parentPort.once('message', (request) => run(parentPort, request)));
