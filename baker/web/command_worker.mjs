// SPDX-License-Identifier: GPL-3.0-or-later
// The thread of Node in which the command runs, so that the first thread can end it: bin/vxs.mjs.
import fs from 'node:fs';
import path from 'node:path';
import tty from 'node:tty';
import { fileURLToPath } from 'node:url';
import v8 from 'node:v8';
import { parentPort, workerData } from 'node:worker_threads';
import { NodeFiles } from './files_node.mjs';
import { runCommand, sharedMemory } from './host.mjs';
import { availableBytes } from './memory_node.mjs';

// where vxs view finds the template of its page
const folder = fileURLToPath(new URL('../', import.meta.url)).replaceAll(path.sep, '/');
// V8 of Node 20 optimizes functions so soon that a small bake takes a sixth more processor time; other versions may not know the flag
if (process.versions.v8.startsWith('11.')) v8.setFlagsFromString('--wasm-tiering-budget=30000000');

const { args, threads } = workerData;
const memory = threads > 1 ? sharedMemory() : undefined;
const module = new WebAssembly.Module(fs.readFileSync(new URL(memory ? './vxs-threads.wasm' : './vxs.wasm', import.meta.url)));
const status = runCommand(module, {
  args,
  env: { VXS_DATA: folder, ...process.env },
  files: new NodeFiles({
    made: (path) => parentPort.postMessage({ made: path }),
    gone: (path) => parentPort.postMessage({ gone: path }),
  }),
  system: {
    process: process.pid,
    processors: 1,
    columns: tty.isatty(1) ? new tty.WriteStream(1).columns : 0,
    availableBytes,
  },
  memory,
  startThreads: memory && (() => parentPort.postMessage({ lent: { module, memory, threads, isOfNode: true } })),
});
parentPort.postMessage({ status });
