#!/usr/bin/env node
// SPDX-License-Identifier: GPL-3.0-or-later
// The command vxs under Node: the same options, messages, exit statuses and bytes as the native one.
import fs from 'node:fs';
import { Worker, receiveMessageOnPort } from 'node:worker_threads';

const INTERRUPTED = 130;
const CRASHED = 134;
// paths of Windows as the command reads paths
const args = process.argv.slice(2).map((a) => (process.platform === 'win32' ? a.replaceAll('\\', '/') : a));
const temporary = new Set();
const worker = new Worker(new URL('../baker/command_worker.mjs', import.meta.url), {
  workerData: { args },
  resourceLimits: { stackSizeMb: 8 },
});

function note({ made, gone, status }) {
  if (made) temporary.add(made);
  if (gone) temporary.delete(gone);
  if (status !== undefined) process.exitCode = status;
}

worker.on('message', note);
worker.on('error', (error) => {
  fs.writeSync(2, `vxs: error: ${error.code === 'ERR_WORKER_OUT_OF_MEMORY' ? 'out of memory' : error.stack}\n`);
  removeTemporary();
  process.exitCode = CRASHED;
});

function removeTemporary() {
  for (const path of temporary) fs.rmSync(path, { force: true });
}

for (const signal of ['SIGINT', 'SIGTERM', 'SIGHUP'])
  process.once(signal, async () => {
    await worker.terminate();
    removeTemporary();
    if (fs.fstatSync(2).isCharacterDevice()) fs.writeSync(2, '\r\x1b[K');
    if (signal === 'SIGINT') process.exit(INTERRUPTED);
    process.kill(process.pid, signal);
  });
