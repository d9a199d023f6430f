// SPDX-License-Identifier: MIT
// Streams: files larger than memory, read over fetch by ranges. vxs_stream.h describes what C does; here bytes are fetched.
import { VXSError } from './instance.mjs';
import { Opened, integer, vector } from './light.mjs';

const HEADER_BYTES = 64, ENTRY_BYTES = 48, SECTIONS_MAX = 20480, PAGES = 0x45474150; // vxs_format.h
const FIRST_BYTES = 64 << 10;  // of the first request; also the least of later ones before the stream is open
const TABLE_BYTES = 4 << 10;   // of a light's pages, whose table comes first
const GAP_BYTES = 16 << 10;    // ranges nearer than this are fetched as one
const FAILED = 0, READ = 1, PENDING = 2;
const RESULT_READ = 3;
const FOCUS_BYTES = 64, FOCI_MAX = 512;
const ATTEMPTS = 4; // of a read during open
const IDLE_MS = 4, IDLE_MAX = 300; // a page is tried again after 256 frames at most
const STATUS = ['bytesHeld', 'bytesResident', 'bytesRoom', 'bytesRead', 'pages', 'pagesResident', 'pagesWanted', 'pagesMissing',
  'pagesComing', 'pagesFailed', 'reads', 'decodes', 'appeared', 'left'];

const failure = (message, cause) => new VXSError('read', message, { cause });

/** A file on a server. read() gives exactly the bytes of a range, or throws. */
class RemoteFile {
  #url; #fetch; #timeout; #reads = new Set(); #tag;

  constructor(url, fetch, timeout) {
    this.#url = String(url);
    this.#fetch = (...request) => fetch(...request); // browsers refuse to call it as a method
    this.#timeout = timeout;
    this.closed = false;
    this.size = 0;      // bytes; 0: not known yet
    this.whole = null;  // all bytes, from a server without ranges
  }

  close() {
    this.closed = true;
    for (const read of this.#reads) read.abort();
  }

  async read(first, end) {
    if (this.whole) return this.#part(first, end);
    const abort = new AbortController();
    const late = setTimeout(() => abort.abort(new Error(`no answer within ${this.#timeout} ms`)), this.#timeout);
    this.#reads.add(abort);
    if (this.closed) abort.abort();
    try {
      const headers = { range: `bytes=${first}-${end - 1}`, 'accept-encoding': 'identity' };
      return await this.#take(await this.#fetch(this.#url, { headers, signal: abort.signal }), first, end);
    } catch (error) {
      throw error instanceof VXSError ? error : failure(`${this.#url}: ${(abort.signal.reason ?? error)?.message}`, error);
    } finally {
      clearTimeout(late);
      this.#reads.delete(abort);
    }
  }

  async #take(response, first, end) {
    const { status, headers } = response, tag = headers.get('etag');
    if (status !== 206 && status !== 200) throw failure(`${this.#url}: HTTP status ${status}`);
    if (this.#tag && tag && tag !== this.#tag) throw failure(`${this.#url}: the file has changed on the server`);
    const bytes = new Uint8Array(await response.arrayBuffer());
    if (status === 200) {
      const length = headers.get('content-length');
      if (length && !headers.get('content-encoding') && +length !== bytes.length) {
        throw failure(`${this.#url}: ${bytes.length} of ${length} bytes came`);
      }
      this.whole = bytes;
      this.size = bytes.length;
      return this.#part(first, end);
    }
    const total = /\/(\d+)$/.exec(headers.get('content-range') ?? '');
    // a server of another origin may hide the header; then the file's own header gives the size
    this.size ||= total ? +total[1] : fileBytes(bytes);
    if (total && +total[1] !== this.size) throw failure(`${this.#url}: the file has changed on the server`);
    const wanted = Math.min(end, this.size) - first;
    if (bytes.length !== wanted) throw failure(`${this.#url}: ${bytes.length} of ${wanted} bytes came`);
    this.#tag ??= tag;
    return bytes;
  }

  #part(first, end) {
    if (end > this.size && first) throw failure(`${this.#url}: the file has ${this.size} bytes`);
    return this.whole.subarray(first, end);
  }
}

/** Size in the header of a .vxs file. */
function fileBytes(bytes) {
  if (bytes.length < HEADER_BYTES) return bytes.length;
  return Number(new DataView(bytes.buffer, bytes.byteOffset).getBigUint64(16, true));
}

/** Bytes that have come before the stream is open: [{ first, bytes }]. */
class Cache {
  #file; #parts = [];
  constructor(file) { this.#file = file; }

  find(first, end) {
    const part = this.#parts.find((p) => p.first <= first && first + (end - first) <= p.first + p.bytes.length);
    return part && part.bytes.subarray(first - part.first, end - part.first);
  }

  async get(first, end) {
    if (end <= first || this.find(first, end)) return;
    for (let attempt = 1; ; attempt++) {
      try {
        this.#parts.push({ first, bytes: await this.#file.read(first, end) });
        return;
      } catch (error) {
        if (attempt === ATTEMPTS || this.#file.closed) throw error;
        await new Promise((resolve) => { setTimeout(resolve, 50 << attempt); });
      }
    }
  }

  /** Gets what open needs of all lights: all sections but pages, and the tables of pages. A wrong directory gets nothing. */
  async getSections() {
    const { size } = this.#file, head = this.find(0, HEADER_BYTES);
    if (!head) return;
    const count = new DataView(head.buffer, head.byteOffset).getUint32(12, true), end = HEADER_BYTES + count * ENTRY_BYTES;
    if (count > SECTIONS_MAX || end > size) return;
    await this.get(0, end);
    const bytes = this.find(0, end), view = new DataView(bytes.buffer, bytes.byteOffset), ranges = [];
    for (let at = HEADER_BYTES; at < end; at += ENTRY_BYTES) {
      const first = Number(view.getBigUint64(at + 16, true)), stored = Number(view.getBigUint64(at + 24, true));
      const last = first + (view.getUint32(at, true) === PAGES ? Math.min(stored, TABLE_BYTES) : stored);
      if (last > size || last < first) return;
      const before = ranges.at(-1);
      if (before && first - before.last < GAP_BYTES && first >= before.first) before.last = Math.max(before.last, last);
      else ranges.push({ first, last });
    }
    await Promise.all(ranges.map((r) => this.get(r.first, r.last)));
  }
}

/** Streams of an instance by the number that C knows them by. */
export class Streams {
  #open = new Map(); #next = 1;

  constructor() {
    this.imports = {
      web_read: (id, offset, size, buffer, request) =>
        this.#open.get(id)?.read(offset, size, buffer >>> 0, request >>> 0) ?? FAILED,
      web_failed: (id, light, page, result, finding) => { this.#open.get(id)?.failures.push({ light, page, result, finding }); },
    };
  }

  add(source) {
    this.#open.set(this.#next, source);
    return this.#next++;
  }

  remove(id) { this.#open.delete(id); }
}

/** Reads of a stream, for C. */
class Source {
  failures = []; pending = new Map(); corrupt = new Set(); missing = null;

  constructor(heap, file, cache) {
    this.heap = heap;
    this.file = file;
    this.cache = cache;
  }

  read(first, size, buffer, request) {
    const end = first + size, bytes = this.file.whole ? this.file.whole.subarray(first, end) : this.cache?.find(first, end);
    if (bytes?.length === size) {
      this.heap.u8.set(bytes, buffer);
      return READ;
    }
    if (!request) {
      this.missing = { first, end };
      return FAILED;
    }
    const done = (ok) => {
      if (!this.pending.delete(request)) return;
      this.heap.c.web_stream_done(request, ok);
    };
    this.pending.set(request, this.file.read(first, end).then((got) => {
      if (!this.pending.has(request)) return;
      this.heap.u8.set(got, buffer);
      done(1);
    }).catch(() => done(0)));
    return PENDING;
  }

  /** Ends all reads as failed, so that C may free their memory. */
  close() {
    this.file.close();
    for (const request of [...this.pending.keys()]) {
      this.pending.delete(request);
      this.heap.c.web_stream_done(request, 0);
    }
  }
}

export class Stream extends Opened {
  #source; #changed = [];

  constructor(heap, handle, close, net, source, Light) {
    const { web_stream_light_count: lightCount, web_stream_light: light, web_stream_metadata: metadata } = heap.c;
    super(heap, handle, close, net, { lightCount, light, metadata }, Light);
    this.#source = source;
    [, this.wordCount] = heap.counted(heap.c.web_stream_words, handle);
    this.ranges = !source.file.whole;
    for (const each of this.lights) each.firstWord = heap.c.web_stream_first_word(handle, each.index);
  }

  smokeOf(index) { return this.heap.c.web_stream_smoke(this.handle, index) >>> 0; }

  frame(foci = []) {
    const { heap, handle } = this, at = heap.scratch, out = at + FOCUS_BYTES * FOCI_MAX;
    const list = Array.isArray(foci) ? foci : [foci];
    integer(list.length, 0, FOCI_MAX, 'the number of foci');
    const numbers = list.flatMap(({ position, min = position, max = position, radius = 0, weight = 1 }) => {
      if (!(radius >= 0) || !(weight > 0)) throw new RangeError('a focus has a radius of 0 or more and a weight above 0');
      return [...vector(min, 'position or min'), ...vector(max, 'position or max'), radius, weight];
    });
    heap.f64.set(numbers, at / 8);
    this.#source.failures = [];
    heap.c.web_stream_frame(handle, at, list.length, out);
    this.#keepChanges();
    const status = Object.fromEntries(STATUS.map((name, n) => [name, heap.f64[out / 8 + n]]));
    status.failures = this.#source.failures.map(({ light, page, result, finding }) =>
      ({ light, page, finding, code: result === RESULT_READ ? 'read' : 'corrupt' }));
    return status;
  }

  async load(foci) {
    const source = this.#source;
    for (let idle = 0; ;) {
      const status = this.frame(foci);
      for (const { code, light, page } of status.failures) if (code === 'corrupt') source.corrupt.add(`${light} ${page}`);
      idle = status.pagesComing || status.reads || status.decodes ? 0 : idle + 1;
      // failed reads are tried again some frames later; corrupt pages are not
      if (idle && (status.pagesFailed <= source.corrupt.size || idle > IDLE_MAX)) return status;
      if (idle) await new Promise((resolve) => { setTimeout(resolve, IDLE_MS); });
      else if (source.pending.size) await Promise.race(source.pending.values());
    }
  }

  retry() {
    this.heap.c.web_stream_retry(this.handle);
    this.#source.corrupt.clear();
  }

  words(firstWord = 0, count = this.wordCount - firstWord) {
    const { heap, handle } = this;
    integer(firstWord, 0, this.wordCount, 'firstWord');
    integer(count, 0, this.wordCount - firstWord, 'count');
    const [first] = heap.counted(heap.c.web_stream_words, handle);
    return heap.u32.slice(first + firstWord, first + firstWord + count);
  }

  #keepChanges() {
    const { heap, handle } = this, [at, count] = heap.counted(heap.c.web_stream_changes, handle);
    for (let n = 0; n < count; n++) {
      this.#changed.push([...heap.u32.subarray(at + 2 * n, at + 2 * n + 2)]);
    }
    // more than all words, if the caller takes no changes
    if (this.#changed.reduce((sum, [, count]) => sum + count, 0) > this.wordCount) this.#changed = [[0, this.wordCount]];
  }

  changes() {
    const changed = this.#changed;
    this.#changed = [];
    return changed.map(([firstWord, count]) => ({ firstWord, words: this.words(firstWord, count) }));
  }
}

/** Bytes of a size in an option. */
const size = (value, what) => integer(value, 1, 2 ** 52, what);

export async function openStream(heap, net, streams, Light, url, options = {}) {
  const { budgetBytes, lights, fetch = globalThis.fetch, requests = 6, decodesPerFrame = 1, timeoutMs = 30000, signal } = options;
  size(budgetBytes, 'budgetBytes');
  integer(requests, 1, 64, 'requests');
  integer(decodesPerFrame, 1, 64, 'decodesPerFrame');
  if (typeof fetch !== 'function') throw new TypeError('there is no fetch: give one in the options');
  if (lights && !(Array.isArray(lights) && lights.length && lights.every((name) => typeof name === 'string'))) {
    throw new TypeError('lights must be an array of names');
  }
  const file = new RemoteFile(url, fetch, timeoutMs), cache = new Cache(file), source = new Source(heap, file, cache);
  const id = streams.add(source), stop = () => file.close();
  signal?.addEventListener('abort', stop);
  try {
    signal?.throwIfAborted();
    await cache.get(0, FIRST_BYTES);
    if (!lights) await cache.getSections();
    for (;;) {
      source.missing = null;
      const handle = openOnce(heap, id, file.size, budgetBytes, requests, decodesPerFrame, lights);
      if (handle) {
        source.cache = null;
        const close = (stream) => {
          source.close();
          heap.c.web_stream_close(stream);
          streams.remove(id);
        };
        return new Stream(heap, handle, close, net, source, Light);
      }
      const { missing } = source;
      if (!missing || missing.end > file.size) throw heap.error(heap.scratch);
      await cache.get(missing.first, Math.min(file.size, Math.max(missing.end, missing.first + FIRST_BYTES)));
    }
  } catch (error) {
    file.close();
    streams.remove(id);
    if (signal?.aborted) throw signal.reason;
    throw error;
  } finally {
    signal?.removeEventListener('abort', stop);
  }
}

/** One try to open with the bytes that have come. Returns 0 on failure; the error is in the scratch memory. */
function openOnce(heap, id, bytes, budget, requests, decodes, lights = []) {
  const texts = lights.map((name) => heap.put(new TextEncoder().encode(`${name}\0`)));
  const names = heap.put(Uint32Array.from(texts));
  try {
    return heap.c.web_stream_open(id, bytes, budget, requests, decodes, names, texts.length, heap.scratch) >>> 0;
  } finally {
    [...texts, names].forEach((at) => heap.free(at));
  }
}
