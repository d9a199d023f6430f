// SPDX-License-Identifier: GPL-3.0-or-later
// Memory that Node's system has to give.
import os from 'node:os';

// asked for often; the system needs some 0.1 ms to say it
const KEPT_MS = 20;
const available = { bytes: 0, at: -Infinity };

export function availableBytes() {
  if (performance.now() - available.at > KEPT_MS) {
    available.bytes = process.availableMemory?.() ?? os.freemem();
    available.at = performance.now();
  }
  return available.bytes;
}
