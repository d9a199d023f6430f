// SPDX-License-Identifier: MIT
// An instance of the WebAssembly module: loading, its memory, errors. Nothing is global: each load() has its own memory.

const CODES = {
  1: 'argument', 2: 'memory', 3: 'read', 10: 'notVxs', 11: 'version', 12: 'truncated', 13: 'corrupt',
};

export class VXSError extends Error {
  constructor(code, message, details = {}) {
    super(message, details.cause === undefined ? undefined : { cause: details.cause });
    this.name = 'VXSError';
    this.code = code;
    this.finding = details.finding ?? 0;
    this.section = details.section ?? -1;
    this.offset = details.offset ?? 0;
  }
}

/** The exports and the memory of an instance. Views are renewed after the memory has grown. */
export class Heap {
  #u8; #f32; #u32; #f64; #scratch = 0;

  constructor(instance) {
    this.c = instance.exports;
    this.c._initialize?.();
    this.#renew();
  }

  #renew() {
    const { buffer } = this.c.memory;
    this.#u8 = new Uint8Array(buffer);
    this.#f32 = new Float32Array(buffer);
    this.#u32 = new Uint32Array(buffer);
    this.#f64 = new Float64Array(buffer);
  }

  // growth detaches the old buffer, which then has a length of 0
  get u8() { if (!this.#u8.length) this.#renew(); return this.#u8; }
  get f32() { if (!this.#f32.length) this.#renew(); return this.#f32; }
  get u32() { if (!this.#u32.length) this.#renew(); return this.#u32; }
  get f64() { if (!this.#f64.length) this.#renew(); return this.#f64; }

  /** Bytes of memory that the instance holds. */
  get size() { return this.c.memory.buffer.byteLength; }

  take(bytes) {
    const at = this.c.malloc(bytes || 1) >>> 0;
    if (!at) throw new VXSError('memory', `out of memory: ${bytes} bytes`);
    return at;
  }

  free(at) { this.c.free(at); }

  /** Memory for arguments and results of one call: Heap.SCRATCH bytes. */
  get scratch() { return this.#scratch ||= this.take(Heap.SCRATCH); }

  /** A copy of bytes in new memory, which the caller frees. */
  put(data) {
    const bytes = bytesOf(data), at = this.take(bytes.length);
    this.u8.set(bytes, at);
    return at;
  }

  /** What a function of C returns and counts: [index in u32, count]. */
  counted(call, of) {
    const first = call(of, this.scratch) >>> 2;
    return [first, this.u32[this.scratch / 4]];
  }

  text(at) {
    at >>>= 0;
    return new TextDecoder().decode(this.u8.slice(at, this.u8.indexOf(0, at)));
  }

  /** The error that vxs_web.c wrote at `at`: struct web_error. */
  error(at) {
    const [result, finding, section, text] = this.u32.subarray(at / 4, at / 4 + 4);
    const message = this.text(text) + (finding ? ` (finding ${finding})` : '');
    return new VXSError(CODES[result] ?? 'read', message, { finding, section: section | 0, offset: this.f64[at / 8 + 2] });
  }
}
Heap.SCRATCH = 64 << 10;

/** Bytes of an ArrayBuffer or of any view of one. */
export function bytesOf(data, what = 'bytes') {
  if (ArrayBuffer.isView(data)) return new Uint8Array(data.buffer, data.byteOffset, data.byteLength);
  if (data instanceof ArrayBuffer || Object.prototype.toString.call(data) === '[object SharedArrayBuffer]' ||
      Object.prototype.toString.call(data) === '[object ArrayBuffer]') return new Uint8Array(data);
  throw new TypeError(`${what} must be an ArrayBuffer or a view of one`);
}

async function responseOf(url) {
  try {
    if (url.protocol !== 'file:') return await fetch(url);
    const fs = 'node:fs/promises'; // a variable, so that bundlers for browsers do not look for it
    const { readFile } = await import(/* webpackIgnore: true */ /* @vite-ignore */ fs);
    return await readFile(url);
  } catch (cause) {
    throw new VXSError('read', `${url}: ${cause.message}`, { cause });
  }
}

/**
 * @param source  URL, string, Response, bytes, WebAssembly.Module, or a promise of one of them
 * @param imports functions of the `env` module
 */
export async function instantiate(source, imports = {}) {
  source = await source;
  const env = { emscripten_notify_memory_growth() {}, ...imports };
  if (typeof source === 'string') source = new URL(source, globalThis.location?.href ?? 'file:///');
  if (source instanceof URL) source = await responseOf(source);
  if (source instanceof WebAssembly.Module) return new Heap(await WebAssembly.instantiate(source, { env }));
  if (typeof Response === 'function' && source instanceof Response) {
    if (!source.ok) throw new VXSError('read', `${source.url || 'the WebAssembly file'}: HTTP status ${source.status}`);
    source = await source.arrayBuffer();
  }
  return new Heap((await WebAssembly.instantiate(bytesOf(source, 'wasm'), { env })).instance);
}
