// SPDX-License-Identifier: GPL-3.0-or-later
// Files in memory, for host.mjs: one folder, /, whose files are a Map of names to bytes.
import { fileError } from './host.mjs';

const O_WRONLY = 1;
const O_RDWR = 2;
const O_CREAT = 0o100;
const O_EXCL = 0o200;
const O_TRUNC = 0o1000;
const O_DIRECTORY = 0o200000;

export class MemoryFiles {
  /**
   * @param {Record<string, Uint8Array>} files
   * @param {(fd: 1 | 2, bytes: Uint8Array) => void} print    takes what is written to standard output and standard error
   */
  constructor(files, print) {
    this.files = new Map(Object.entries(files).map(([name, bytes]) => [this.name(name), this.file(bytes)]));
    this.print = print;
  }

  /** The name of a path: without '.', '..' and leading slashes. */
  name(path) {
    const parts = [];
    for (const part of path.split('/')) {
      if (part === '..') parts.pop();
      else if (part && part !== '.') parts.push(part);
    }
    return parts.join('/');
  }

  file(bytes) {
    this.last = (this.last ?? 1) + 1;
    return { bytes, size: bytes.length, inode: this.last };
  }

  isFolder(name) {
    return !name || [...this.files.keys()].some((other) => other.startsWith(`${name}/`));
  }

  at(path) {
    const name = this.name(path);
    const file = this.files.get(name);
    if (!file && !this.isFolder(name)) throw fileError('ENOENT');
    return file ?? { isFolder: true, size: 0, inode: 1 };
  }

  /** Bytes of a file when the run has ended; undefined: there is none. */
  bytes(path) {
    const file = this.files.get(this.name(path));
    return file && file.bytes.subarray(0, file.size);
  }

  open(path, flags) {
    const name = this.name(path);
    const found = this.files.get(name);
    if (found && flags & O_EXCL) throw fileError('EEXIST');
    if (found && flags & O_DIRECTORY) throw fileError('ENOTDIR');
    if (!found && this.isFolder(name)) {
      if (flags & (O_WRONLY | O_RDWR)) throw fileError(flags & O_DIRECTORY ? 'EOPNOTSUPP' : 'EISDIR');
      return { handle: { isFolder: true, size: 0, inode: 1 }, position: 0 };
    }
    if (!found && !(flags & O_CREAT)) throw fileError('ENOENT');
    const file = found ?? this.file(new Uint8Array(0));
    if (flags & O_TRUNC) file.size = 0;
    this.files.set(name, file);
    return { handle: file, position: 0 };
  }

  close() {}

  read(file, to, position) {
    if (file === 0) return 0;
    if (file.isFolder) throw fileError('EISDIR');
    const from = file.bytes.subarray(position, Math.min(file.size, position + to.length));
    to.set(from);
    return from.length;
  }

  write(file, from, position) {
    if (file === 1 || file === 2) {
      this.print(file, from.slice());
      return from.length;
    }
    const end = position + from.length;
    if (end > file.bytes.length) {
      const larger = new Uint8Array(Math.max(end, 2 * file.bytes.length));
      larger.set(file.bytes);
      file.bytes = larger;
    }
    file.bytes.set(from, position);
    file.size = Math.max(file.size, end);
    return from.length;
  }

  stat(path) {
    return this.fstat(this.at(path));
  }

  fstat(file) {
    const kind = typeof file === 'number' ? 0o010600 : file.isFolder ? 0o040755 : 0o100644;
    return { dev: 1, ino: file.inode ?? 0, mode: kind, nlink: 1, uid: 0, gid: 0, size: BigInt(file.size ?? 0), mtimeNs: 0n };
  }

  list(path) {
    const folder = this.name(path);
    const start = folder ? `${folder}/` : '';
    const inside = [...this.files.keys()].filter((name) => name.startsWith(start));
    return [...new Set(inside.map((name) => name.slice(start.length).split('/')[0]))];
  }

  unlink(path) {
    this.at(path);
    this.files.delete(this.name(path));
  }

  rename(from, to) {
    const file = this.at(from);
    this.files.delete(this.name(from));
    this.files.set(this.name(to), file);
  }

  mkdir() {
    throw fileError('ENOSYS');
  }

  realpath(path) {
    this.at(path);
    return `/${this.name(path)}`;
  }

  access(path) {
    this.at(path);
  }

  chmod() {}

  chown() {}

  sync() {}

  isTerminal() {
    return false;
  }
}
