// SPDX-License-Identifier: GPL-3.0-or-later
// The files of Node's host, for host.mjs.
import fs from 'node:fs';
import path from 'node:path';
import tty from 'node:tty';
import { fileError } from './host.mjs';

// flags of open in emscripten's C library; the lowest two bits are the same everywhere
const ACCESS = 3;
const FLAGS = Object.entries({
  O_CREAT: 0o100, O_EXCL: 0o200, O_TRUNC: 0o1000, O_APPEND: 0o2000, O_NONBLOCK: 0o4000, O_NOFOLLOW: 0o400000,
}).map(([name, ours]) => [ours, fs.constants[name] ?? 0]);
const O_EXCL = 0o200;
const O_DIRECTORY = 0o200000;

/** Calls again while a pipe or a terminal that does not block has no data, or no room. */
function patient(call) {
  for (;;) {
    try {
      return call();
    } catch (error) {
      if (error.code !== 'EAGAIN') throw error;
      Atomics.wait(new Int32Array(new SharedArrayBuffer(4)), 0, 0, 5);
    }
  }
}

export class NodeFiles {
  /**
   * @param {object} watch    told of temporary files, by absolute path, so that another thread can remove them if the run is ended
   * @param {(path: string) => void} watch.made
   * @param {(path: string) => void} watch.gone
   */
  constructor({ made, gone }) {
    this.made = made;
    this.gone = gone;
  }

  open(name, flags, mode) {
    if (flags & O_DIRECTORY) return this.openFolder(name, flags);
    let native = flags & ACCESS;
    for (const [ours, theirs] of FLAGS) if (flags & ours) native |= theirs;
    const handle = fs.openSync(name, native, mode);
    if (flags & O_EXCL) this.made(path.resolve(name));
    return { handle, position: fs.fstatSync(handle).isFile() ? 0 : null };
  }

  /** Folders are not opened everywhere: a handle is { folder, descriptor }. Files without a name are not offered: Node
   *  could not give them one later (no linkat with AT_SYMLINK_FOLLOW). */
  openFolder(name, flags) {
    if (flags & ACCESS) throw fileError('EOPNOTSUPP');
    if (!fs.statSync(name).isDirectory()) throw fileError('ENOTDIR');
    const descriptor = process.platform === 'win32' ? -1 : fs.openSync(name, fs.constants.O_RDONLY | fs.constants.O_DIRECTORY);
    return { handle: { folder: name, descriptor }, position: null };
  }

  close(handle) {
    if (typeof handle === 'number') fs.closeSync(handle);
    else if (handle.descriptor >= 0) fs.closeSync(handle.descriptor);
  }

  read(handle, bytes, position) {
    if (typeof handle !== 'number') throw fileError('EISDIR');
    try {
      return patient(() => fs.readSync(handle, bytes, 0, bytes.length, position));
    } catch (error) {
      if (error.code === 'EOF') return 0; // a pipe's end on Windows
      throw error;
    }
  }

  write(handle, bytes, position) {
    return patient(() => fs.writeSync(handle, bytes, 0, bytes.length, position));
  }

  stat(name, isFollowed) {
    return isFollowed ? fs.statSync(name, { bigint: true }) : fs.lstatSync(name, { bigint: true });
  }

  fstat(handle) {
    return typeof handle === 'number' ? fs.fstatSync(handle, { bigint: true }) : fs.statSync(handle.folder, { bigint: true });
  }

  list(folder) {
    return fs.readdirSync(folder);
  }

  unlink(name) {
    fs.unlinkSync(name);
    this.gone(path.resolve(name));
  }

  rename(from, to) {
    fs.renameSync(from, to);
    this.gone(path.resolve(from));
  }

  mkdir(name, mode) {
    fs.mkdirSync(name, mode);
  }

  realpath(name) {
    return fs.realpathSync.native(name).replaceAll(path.sep, '/');
  }

  access(name, mode) {
    fs.accessSync(name, mode);
  }

  chmod(handle, mode) {
    fs.fchmodSync(handle, mode);
  }

  chown(handle, uid, gid) {
    fs.fchownSync(handle, uid, gid);
  }

  sync(handle) {
    const descriptor = typeof handle === 'number' ? handle : handle.descriptor;
    if (descriptor >= 0) fs.fsyncSync(descriptor);
  }

  isTerminal(handle) {
    return typeof handle === 'number' && tty.isatty(handle);
  }
}
