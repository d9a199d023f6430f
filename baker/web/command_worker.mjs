// SPDX-License-Identifier: GPL-3.0-or-later
// The thread of Node in which the command runs, so that the first thread can end it: bin/vxs.mjs.
import fs from 'node:fs';
import os from 'node:os';
import tty from 'node:tty';
import { parentPort, workerData } from 'node:worker_threads';
import { NodeFiles } from './files_node.mjs';
import { runCommand } from './host.mjs';

const module = new WebAssembly.Module(fs.readFileSync(new URL('./vxs.wasm', import.meta.url)));
const status = runCommand(module, {
  args: workerData.args,
  env: process.env,
  files: new NodeFiles({
    made: (path) => parentPort.postMessage({ made: path }),
    gone: (path) => parentPort.postMessage({ gone: path }),
  }),
  system: {
    process: process.pid,
    processors: 1,
    columns: tty.isatty(1) ? new tty.WriteStream(1).columns : 0,
    availableBytes: () => process.availableMemory?.() ?? os.freemem(),
  },
});
parentPort.postMessage({ status });
