// A page in headless Chromium for tests: served from this machine, with the package and three.js as a user's page would have them.
// SPDX-License-Identifier: GPL-3.0-or-later
import fs from 'node:fs';
import http from 'node:http';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
const PACKAGE = process.env.VXS_PACKAGE ?? path.resolve(here, '../../build/web/vxs');
const LIBRARIES = path.resolve(PACKAGE, '../node_modules');
const CHROMIUM = process.env.CHROMIUM ?? '/usr/bin/chromium';

/** Why tests cannot run a browser here; false if they can. For the option `skip` of node:test. */
export const noBrowser = !fs.existsSync(CHROMIUM) ? `no browser at ${CHROMIUM}: set CHROMIUM`
  : !fs.existsSync(path.join(LIBRARIES, 'puppeteer-core')) ? 'puppeteer-core is not installed: make web' : false;

const TYPES = { '.mjs': 'text/javascript', '.js': 'text/javascript', '.json': 'application/json', '.wasm': 'application/wasm', '.html': 'text/html' };

/** Releases of three.js under test: a package of build/web/node_modules for each. */
export const RELEASES = ['three', 'three-oldest'];

/** Text of a page with an import map, as in docs/web.md. webgpu: `three` is the build with WebGPURenderer. */
const pageText = (three, webgpu) => `<!doctype html><meta charset="utf-8"><title>test</title>
<link rel="icon" href="data:,"><style>body { margin: 0 }</style>
<script type="importmap">${JSON.stringify({ imports: {
    three: `/lib/${three}/build/${webgpu ? 'three.webgpu.js' : 'three.module.js'}`,
    'three/webgpu': `/lib/${three}/build/three.webgpu.js`,
    'three/tsl': `/lib/${three}/build/three.tsl.js`,
    'three/addons/': `/lib/${three}/examples/jsm/`,
    vxs: '/vxs/runtime/vxs.mjs',
    'vxs/shaders': '/vxs/runtime/shaders.mjs',
    'vxs/three': '/vxs/three/index.mjs',
    'vxs/three/webgpu': '/vxs/three/webgpu.mjs',
  } })}</script>`;

/**
 * Serve folders: /vxs the package, /lib the libraries, /tests this folder, /bench tests/bench, and `files`, a folder of the
 * test, as /files. Answers ranges. common: headers of all answers.
 * Returns { url, close() }.
 */
export async function serve(files = here, common = {}) {
  const roots = { vxs: PACKAGE, lib: LIBRARIES, tests: here, bench: path.resolve(here, '../bench'), files };
  const server = http.createServer((request, response) => {
    const url = new URL(request.url, 'http://localhost'), [, root, ...rest] = decodeURIComponent(url.pathname).split('/');
    if (root === 'page') {
      response.writeHead(200, { ...common, 'content-type': 'text/html' });
      return response.end(pageText(url.searchParams.get('three'), url.searchParams.has('webgpu')));
    }
    const file = path.join(roots[root] ?? '/nowhere', ...rest);
    if (!roots[root] || !file.startsWith(roots[root]) || !fs.existsSync(file) || !fs.statSync(file).isFile()) {
      response.writeHead(404);
      return response.end();
    }
    const bytes = fs.readFileSync(file), range = /^bytes=(\d+)-(\d*)$/.exec(request.headers.range ?? '');
    const type = TYPES[path.extname(file)] ?? 'application/octet-stream', headers = { ...common, 'content-type': type, 'accept-ranges': 'bytes' };
    if (!range) {
      response.writeHead(200, { ...headers, 'content-length': bytes.length });
      return response.end(bytes);
    }
    const begin = Number(range[1]), end = Math.min(bytes.length - 1, range[2] ? Number(range[2]) : Infinity);
    response.writeHead(206, { ...headers, 'content-range': `bytes ${begin}-${end}/${bytes.length}`, 'content-length': end - begin + 1 });
    return response.end(bytes.subarray(begin, end + 1));
  });
  await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));
  return { url: `http://127.0.0.1:${server.address().port}`, close: () => new Promise((resolve) => server.close(resolve)) };
}

/** Start Chromium with software rendering. Close it in `after`. */
export async function launch({ args = [] } = {}) {
  const { default: puppeteer } = await import(createRequire(path.join(LIBRARIES, 'x.mjs')).resolve('puppeteer-core'));
  return puppeteer.launch({
    executablePath: CHROMIUM,
    headless: true,
    protocolTimeout: 600_000,
    userDataDir: fs.mkdtempSync(path.join(os.tmpdir(), 'vxs-browser-')),
    args: ['--no-sandbox', '--disable-dev-shm-usage', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist',
      '--disable-background-networking', '--disable-component-update', '--no-first-run', '--js-flags=--expose-gc', ...args],
  });
}

/**
 * Open a page of a release of three.js. What the console or the page reports as an error or a warning, and requests to other hosts,
 * are collected in page.faults; check() of a test asserts that there are none. `allow`: a pattern of messages that a test expects.
 */
export async function openPage(browser, server, { three = 'three', webgpu = false, allow = null } = {}) {
  const page = await browser.newPage();
  page.faults = [];
  const fault = (text) => (allow?.test(text) ? 0 : page.faults.push(text));
  page.on('console', (message) => {
    if (process.env.VXS_CONSOLE) console.log(message.text());
    if (['error', 'warn', 'warning'].includes(message.type())) fault(`${message.type()}: ${message.text()}`);
  });
  page.on('pageerror', (error) => fault(`page: ${error.stack ?? error.message}`));
  page.on('requestfailed', (request) => fault(`request: ${request.url()} ${request.failure()?.errorText}`));
  await page.setRequestInterception(true);
  page.on('request', (request) => {
    if (request.url().startsWith(server.url) || /^(data|blob):/.test(request.url())) return request.continue();
    fault(`network: ${request.url()}`);
    return request.abort();
  });
  await page.goto(`${server.url}/page?three=${three}${webgpu ? '&webgpu' : ''}`);
  return page;
}

/** Run an async function of a page module of this folder: run(page, '/tests/three_page.mjs', 'name', argument). */
export const run = (page, module, name, argument) =>
  page.evaluate(async (from, of, given) => (await import(from))[of](given), module, name, argument);
