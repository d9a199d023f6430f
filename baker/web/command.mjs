#!/usr/bin/env node
// SPDX-License-Identifier: GPL-3.0-or-later
// The command vxs under Node: the same options, messages, exit statuses and bytes as the native one.
import fs from 'node:fs';
import { Worker } from 'node:worker_threads';

const INTERRUPTED = 130;
const CRASHED = 134;
// paths of Windows as the command reads paths
const args = process.argv.slice(2).map((a) => (process.platform === 'win32' ? a.replaceAll('\\', '/') : a));
const temporary = new Set();
let isEnded = false;
let endThreads = () => {};

/** The value of --threads; 1 where it is missing or no number. The command reports a wrong one. */
function threadsOf(line) {
  const at = line.findLastIndex((a) => /^--threads(=|$)/.test(a));
  return at < 0 ? 1 : Number(line[at].split('=')[1] ?? line[at + 1]) || 1;
}

const worker = new Worker(new URL('../baker/command_worker.mjs', import.meta.url), {
  workerData: { args, threads: threadsOf(args) },
  resourceLimits: { stackSizeMb: 8 },
});

async function lend(lent) {
  const { startThreads } = await import(new URL('../baker/workers.mjs', import.meta.url));
  if (!isEnded) endThreads = startThreads(lent, fail);
}

function end() {
  isEnded = true;
  endThreads();
}

function note({ made, gone, status, lent }) {
  if (made) temporary.add(made);
  if (gone) temporary.delete(gone);
  if (lent) lend(lent);
  if (status === undefined) return;
  process.exitCode = status;
  end();
}

/** Ends the command because a thread has failed. */
async function fail({ status, messages }) {
  end();
  await worker.terminate();
  fs.writeSync(2, messages);
  removeTemporary();
  process.exitCode = status;
}

worker.on('message', note);
worker.on('error', (error) =>
  fail({ status: CRASHED, messages: `vxs: error: ${error.code === 'ERR_WORKER_OUT_OF_MEMORY' ? 'out of memory' : error.stack}\n` }));

function removeTemporary() {
  for (const path of temporary) fs.rmSync(path, { force: true });
}

for (const signal of ['SIGINT', 'SIGTERM', 'SIGHUP'])
  process.once(signal, async () => {
    end();
    await worker.terminate();
    removeTemporary();
    if (fs.fstatSync(2).isCharacterDevice()) fs.writeSync(2, '\r\x1b[K');
    if (signal === 'SIGINT') process.exit(INTERRUPTED);
    process.kill(process.pid, signal);
  });
