// SPDX-License-Identifier: GPL-3.0-or-later
// Workers of a browser or of Node: the one in which a command runs, and its threads.

// as many as threads_web.c has places for, and the first thread
const THREADS_MAX = 64;

/**
 * A worker with the few functions that both kinds have.
 * @param {() => Worker} inBrowser   makes it there; bundlers find its module in the caller's text
 * @param {URL} url                  of its module, for Node
 */
export async function startWorker(inBrowser, url) {
  if (typeof Worker === 'function') {
    const worker = inBrowser();
    return {
      post: (message) => worker.postMessage(message),
      onMessage: (call) => worker.addEventListener('message', (event) => call(event.data)),
      onError: (call) => worker.addEventListener('error', (event) => call(new Error(event.message || 'the worker cannot be loaded'))),
      end: () => worker.terminate(),
    };
  }
  const threads = await import(/* @vite-ignore */ /* webpackIgnore: true */ 'node:worker_threads');
  const worker = new threads.Worker(url, { resourceLimits: { stackSizeMb: 8 } });
  return {
    post: (message) => worker.postMessage(message),
    onMessage: (call) => worker.on('message', call),
    onError: (call) => worker.on('error', call),
    end: () => worker.terminate(),
  };
}

const threadInBrowser = () => new Worker(new URL('./thread_worker.mjs', import.meta.url), { type: 'module' });

/**
 * Starts the threads of a command that runs in another worker. A thread that cannot be started is missing, and the others do its work.
 * @param {object} lent   { module, memory, threads, isOfNode }: threads with the first, in which the command runs; whether that is bin/vxs.mjs
 * @param {(failure: { status: number, messages: string }) => void} onFailure   the command must end, because a thread has failed
 * @returns a function that ends the threads
 */
export function startThreads({ threads, ...request }, onFailure) {
  const workers = [];
  let isEnded = false;
  async function start(number) {
    const worker = await startWorker(threadInBrowser, new URL('./thread_worker.mjs', import.meta.url));
    if (isEnded) return worker.end();
    workers.push(worker);
    worker.onMessage(onFailure);
    worker.onError(() => {});
    worker.post({ ...request, number });
  }
  for (let number = 0; number < Math.min(threads, THREADS_MAX) - 1; number++) start(number).catch(() => {});
  return () => {
    isEnded = true;
    for (const worker of workers) worker.end();
  };
}
