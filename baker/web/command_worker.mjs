// SPDX-License-Identifier: GPL-3.0-or-later
// The thread of Node in which the command runs, so that the first thread can end it: bin/vxs.mjs.
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';
import tty from 'node:tty';
import { fileURLToPath } from 'node:url';
import { parentPort, workerData } from 'node:worker_threads';
import { NodeFiles } from './files_node.mjs';
import { runCommand } from './host.mjs';

// where vxs view finds the template of its page
const folder = fileURLToPath(new URL('../', import.meta.url)).replaceAll(path.sep, '/');
// asked for often; the system needs some 0.1 ms to say it
const KEPT_MS = 20;
const available = { bytes: 0, at: -Infinity };
function availableBytes() {
  if (performance.now() - available.at > KEPT_MS) {
    available.bytes = process.availableMemory?.() ?? os.freemem();
    available.at = performance.now();
  }
  return available.bytes;
}

const module = new WebAssembly.Module(fs.readFileSync(new URL('./vxs.wasm', import.meta.url)));
const status = runCommand(module, {
  args: workerData.args,
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
});
parentPort.postMessage({ status });
