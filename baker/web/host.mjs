// SPDX-License-Identifier: GPL-3.0-or-later
// Runs the WebAssembly command: what system_web.c imports, and the WASI calls of emscripten's C library, on files that the caller gives
// (files_node.mjs, files_memory.mjs).

// errno of emscripten's C library, which are those of WASI
const ERRNO = {
  EACCES: 2, EAGAIN: 6, EBADF: 8, EBUSY: 10, EDQUOT: 19, EEXIST: 20, EFAULT: 21, EFBIG: 22, EINTR: 27, EINVAL: 28, EIO: 29, EISDIR: 31,
  ELOOP: 32, EMFILE: 33, EMLINK: 34, ENAMETOOLONG: 37, ENFILE: 41, ENODEV: 43, ENOENT: 44, ENOMEM: 48, ENOSPC: 51, ENOSYS: 52,
  ENOTDIR: 54, ENOTEMPTY: 55, ENOTSUP: 58, EOPNOTSUPP: 58, ENOTTY: 59, ENXIO: 60, EPERM: 63, EPIPE: 64, EROFS: 69, ESPIPE: 70,
  ETXTBSY: 74, EXDEV: 75,
};
const AT_FDCWD = -100;
const LARGEST_READ = 1 << 30;
const PAGES = { initial: 256, maximum: 65536 };
// of threads_web.c: the state of a worker, and the words of its place
const ARRIVED = 1;
const BUSY = 4;
const STATE = 0;
const STACK_TOP = 1;

/** An error of a file operation, with the code that Node gives such errors. */
export function fileError(code) {
  return Object.assign(new Error(code), { code });
}

class Exit extends Error {
  constructor(status) {
    super(`exit ${status}`);
    this.status = status;
  }
}

const OUT_OF_MEMORY = 6;
const CRASHED = 134;

/** How a command ends that an error of the host has ended: the exit status and a message. */
export function failureOf(error) {
  const status = error instanceof RangeError ? OUT_OF_MEMORY : CRASHED;
  return { status, messages: `vxs: error: ${status === OUT_OF_MEMORY ? 'out of memory' : error.message}\n` };
}

/** Memory for a module that needsMemory(); undefined where the host lends none. */
export function sharedMemory() {
  try {
    return new WebAssembly.Memory({ ...PAGES, shared: true });
  } catch {
    return undefined;
  }
}

/** Whether a module is the one with threads. */
export const needsMemory = (module) => WebAssembly.Module.imports(module).some(({ kind }) => kind === 'memory');

// threads must agree on the time, and each has its own origin
const clocks = { 0: () => Date.now(), 1: () => performance.timeOrigin + performance.now() };
const nanoseconds = (clock) => BigInt(Math.round((clocks[clock] ?? clocks[1])() * 1e6));

/** Descriptors of a run. Each is { handle, position, users, path, isBroken }; position is null where files have none: pipes, terminals. */
class Descriptors {
  constructor(files) {
    this.files = files;
    this.open = [0, 1, 2].map((handle) => ({ handle, position: null, users: 1 }));
  }

  at(fd) {
    const d = this.open[fd];
    if (!d) throw fileError('EBADF');
    return d;
  }

  add(d) {
    let fd = this.open.findIndex((other) => !other);
    if (fd < 0) fd = this.open.length;
    this.open[fd] = d;
    return fd;
  }

  dup(fd, to) {
    const d = this.at(fd);
    d.users++;
    if (to < 0) return this.add(d);
    if (this.open[to]) this.close(to);
    this.open[to] = d;
    return to;
  }

  close(fd) {
    const d = this.at(fd);
    this.open[fd] = undefined;
    if (--d.users === 0 && d.handle !== 0 && d.handle !== 1 && d.handle !== 2) this.files.close(d.handle);
  }

  read(fd, bytes, position) {
    const d = this.at(fd);
    const n = this.files.read(d.handle, bytes.subarray(0, LARGEST_READ), position ?? d.position);
    if (position === undefined && d.position !== null) d.position += n;
    return n;
  }

  write(fd, bytes) {
    const d = this.at(fd);
    let n;
    try {
      n = this.files.write(d.handle, bytes, d.position);
    } catch (error) {
      d.isBroken = error.code === 'EPIPE';
      throw error;
    }
    if (d.position !== null) d.position += n;
    return n;
  }

  seek(fd, offset, whence) {
    const d = this.at(fd);
    if (d.position === null) throw fileError('ESPIPE');
    const from = whence === 0 ? 0 : whence === 1 ? d.position : this.files.fstat(d.handle).size;
    if (Number(from) + offset < 0) throw fileError('EINVAL');
    return (d.position = Number(from) + offset);
  }
}

/**
 * Runs the command.
 * @param {WebAssembly.Module} module
 * @param {object} run
 * @param {string[]} run.args    the command line, after the name of the program
 * @param {Record<string, string>} run.env
 * @param {object} run.files     file operations; they throw errors with a code
 * @param {object} run.system    { process, processors, availableBytes(), columns?, progress?(share, doing) }
 * @param {WebAssembly.Memory} [run.memory]   of a module with threads
 * @param {() => void} [run.startThreads]     called before the command runs: calls runThread in other workers
 * @returns {number} the exit status
 */
export function runCommand(module, { args, env, files, system, memory, startThreads }) {
  const descriptors = new Descriptors(files);
  const encoder = new TextEncoder();
  const decoder = new TextDecoder();
  let bytes = new Uint8Array(0);
  const heap = () => (bytes.buffer === memory.buffer ? bytes : (bytes = new Uint8Array(memory.buffer)));
  const view = () => new DataView(memory.buffer);
  const slice = (at, size) => heap().subarray(at >>> 0, (at >>> 0) + (size >>> 0));
  const setSize = (at, value) => view().setUint32(at >>> 0, value, true);

  function text(at) {
    const all = heap();
    return decoder.decode(all.slice(at >>> 0, all.indexOf(0, at >>> 0))); // no decoder reads shared memory
  }

  /** The path of a name in an open folder. */
  function pathIn(dir, at) {
    const name = text(at);
    if (dir === AT_FDCWD || name.startsWith('/')) return name;
    return `${descriptors.at(dir).path}/${name}`;
  }

  /** Writes bytes, if there is room for them. Returns their number. */
  function put(from, at, room) {
    if (from.length <= room) heap().set(from, at >>> 0);
    return from.length;
  }

  function putStat(s, at) {
    const numbers = [s.dev, s.ino, s.mode, s.nlink, s.uid, s.gid, s.size, s.mtimeNs / 1000000000n, s.mtimeNs % 1000000000n];
    const to = view();
    numbers.forEach((n, i) => to.setBigInt64((at >>> 0) + 8 * i, BigInt.asIntN(64, BigInt(n)), true));
    return 0;
  }

  /** A function of the host whose errors are returned, as a negated errno or as a WASI errno. */
  const guarded = (sign, call) => (...parameters) => {
    try {
      return call(...parameters) ?? 0;
    } catch (error) {
      if (error instanceof Exit || !error.code) throw error;
      return sign * (ERRNO[error.code] ?? ERRNO.EIO);
    }
  };
  const guardAll = (sign, calls) => Object.fromEntries(Object.entries(calls).map(([name, call]) => [name, guarded(sign, call)]));

  const vxs = guardAll(-1, {
    open(dir, path, flags, mode) {
      const name = pathIn(dir, path);
      return descriptors.add({ ...files.open(name, flags, mode), path: name, users: 1 });
    },
    stat: (dir, path, isLinkItself, out) => putStat(files.stat(pathIn(dir, path), !isLinkItself), out),
    fstat: (fd, out) => putStat(files.fstat(descriptors.at(fd).handle), out),
    list: (fd, out, room) => put(encoder.encode(files.list(descriptors.at(fd).path).map((name) => `${name}\0`).join('')), out, room),
    unlink: (dir, path) => files.unlink(pathIn(dir, path)),
    rename: (from, to) => files.rename(text(from), text(to)),
    mkdir: (path, mode) => files.mkdir(text(path), mode),
    realpath(path, out, room) {
      if (put(encoder.encode(`${files.realpath(text(path))}\0`), out, room) > room) throw fileError('ENAMETOOLONG');
    },
    access: (path, mode) => files.access(text(path), mode),
    chmod: (fd, mode) => files.chmod(descriptors.at(fd).handle, mode),
    chown: (fd, uid, gid) => files.chown(descriptors.at(fd).handle, uid, gid),
    dup: (fd, to) => descriptors.dup(fd, to),
    is_open: (fd) => Number(Boolean(descriptors.open[fd])),
    is_terminal: (fd) => Number(files.isTerminal(descriptors.at(fd).handle)),
    is_broken: (fd) => Number(Boolean(descriptors.at(fd).isBroken)),
    columns: () => system.columns ?? 0,
    process: () => system.process,
    processors: () => system.processors,
    shows_progress: () => Number(Boolean(system.progress)),
    show_progress: (share, doing) => system.progress(share < 0 ? undefined : share, text(doing)),
    available_bytes: () => system.availableBytes(),
  });

  const argumentBytes = ['vxs', ...args].map((a) => encoder.encode(`${a}\0`));
  const environmentBytes = Object.entries(env).map(([name, value]) => encoder.encode(`${name}=${value}\0`));
  function putTexts(texts, pointers, at) {
    let to = at >>> 0;
    texts.forEach((one, i) => {
      setSize((pointers >>> 0) + 4 * i, to);
      heap().set(one, to);
      to += one.length;
    });
  }
  function putSizes(texts, count, size) {
    setSize(count, texts.length);
    setSize(size, texts.reduce((sum, one) => sum + one.length, 0));
  }
  /** Calls transfer(part) for each part of a vector, until one is short. */
  function transferAll(vector, count, size, transfer) {
    let sum = 0;
    for (let i = 0; i < count; i++) {
      const at = (vector >>> 0) + 8 * i;
      const length = view().getUint32(at + 4, true);
      const n = length ? transfer(slice(view().getUint32(at, true), length)) : 0;
      sum += n;
      if (n < length) break;
    }
    setSize(size, sum);
  }
  const wasi = guardAll(1, {
    args_get: (pointers, at) => putTexts(argumentBytes, pointers, at),
    args_sizes_get: (count, size) => putSizes(argumentBytes, count, size),
    environ_get: (pointers, at) => putTexts(environmentBytes, pointers, at),
    environ_sizes_get: (count, size) => putSizes(environmentBytes, count, size),
    fd_write: (fd, vector, count, size) => transferAll(vector, count, size, (part) => descriptors.write(fd, part)),
    fd_read: (fd, vector, count, size) => transferAll(vector, count, size, (part) => descriptors.read(fd, part)),
    fd_pread: (fd, vector, count, offset, size) => {
      let position = Number(offset);
      transferAll(vector, count, size, (part) => {
        const n = descriptors.read(fd, part, position);
        position += n;
        return n;
      });
    },
    fd_seek: (fd, offset, whence, out) => {
      view().setBigInt64(out >>> 0, BigInt(descriptors.seek(fd, Number(offset), whence)), true);
    },
    fd_close: (fd) => descriptors.close(fd),
    fd_sync: (fd) => files.sync(descriptors.at(fd).handle),
    clock_time_get: (clock, precision, out) => view().setBigUint64(out >>> 0, nanoseconds(clock), true),
    clock_res_get: (clock, out) => view().setBigUint64(out >>> 0, 1000n, true),
    proc_exit: (status) => {
      throw new Exit(status);
    },
  });

  const instance = new WebAssembly.Instance(module, {
    vxs,
    wasi_snapshot_preview1: wasi,
    env: { memory, emscripten_notify_memory_growth() {} },
  });
  memory ??= instance.exports.memory;
  startThreads?.();
  try {
    instance.exports._start();
    return 0;
  } catch (error) {
    if (error instanceof Exit) return error.status;
    throw error;
  }
}

/**
 * Runs work of the command in this worker, until the worker is ended. Threads compute: they call nothing of the host that has a state.
 * @param {number} number            of the thread, from 0 on
 * @param {() => number} availableBytes
 * @returns {number} the exit status, if the command ends here
 */
export function runThread(module, memory, number, availableBytes) {
  const calls = {
    memory,
    emscripten_notify_memory_growth() {},
    available_bytes: availableBytes,
    clock_time_get(clock, precision, out) {
      new DataView(memory.buffer).setBigUint64(out >>> 0, nanoseconds(clock), true);
      return 0;
    },
    proc_exit(status) {
      throw new Exit(status);
    },
  };
  const imports = {};
  for (const { module: from, name } of WebAssembly.Module.imports(module)) {
    const refuse = () => {
      throw new Error(`a thread has called ${name}`);
    };
    (imports[from] ??= {})[name] = calls[name] ?? refuse;
  }
  const { exports } = new WebAssembly.Instance(module, imports);
  const place = exports.worker_place(number);
  const words = new Int32Array(memory.buffer, place, 2);
  Atomics.store(words, STATE, ARRIVED);
  for (let state; (state = Atomics.load(words, STATE)) !== BUSY;) Atomics.wait(words, STATE, state);
  exports.stackRestore(words[STACK_TOP]);
  try {
    return exports.run_worker(place);
  } catch (error) {
    if (error instanceof Exit) return error.status;
    throw error;
  }
}
