// The level that a page shows: what the command wrote into it, or files that were dropped onto it.
//
// A level is { scene: { name, choice, bytes }, files: Map of URI to bytes, asset: { name, bytes } or null, warnings: [text] }.
// SPDX-License-Identifier: MIT

/** An error whose message is for the user. */
export class LevelError extends Error {}

function decodeInto(out, at, text) {
  const bytes = atob(text);
  for (let n = 0; n < bytes.length; n++) out[at + n] = bytes.charCodeAt(n);
  return at + bytes.length;
}

/** The level in this page; null: there is none. Elements are removed as they are read, so that their memory is freed. */
export async function embeddedLevel(document) {
  const element = document.getElementById('vxs-level');
  if (!element) return null;
  const { files, scene, asset, warnings } = JSON.parse(element.textContent);
  const bytes = files.map((file) => new Uint8Array(file.size_bytes)),
    ends = files.map(() => 0);
  for (const part of document.querySelectorAll('script[data-vxs]')) {
    const index = Number(part.dataset.vxs);
    ends[index] = decodeInto(bytes[index], ends[index], part.textContent);
    part.remove();
    await new Promise((resolve) => {
      setTimeout(resolve);
    });
  }
  element.remove();
  if (files.some((file, n) => ends[n] !== file.size_bytes))
    throw new LevelError('This page is not complete: write it again.');
  const beside = files.map((file, n) => [file.uri, bytes[n]]).slice(1, -1);
  return {
    scene: { name: scene.name ?? 'scene', choice: scene.scene, bytes: bytes[0] },
    files: new Map(beside),
    asset: { name: asset.name ?? 'baked shadows', bytes: bytes.at(-1) },
    warnings,
  };
}

const GLB = 0x46546c67,
  JSON_CHUNK = 0x4e4f534a;

/** The JSON of a .gltf or .glb file, and where its binary chunk begins: { json, bin }; bin is 0 if there is none. */
function openGltf(bytes, name) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const damaged = new LevelError(`${name} is damaged: its JSON chunk does not fit.`);
  let text = bytes,
    bin = 0;
  if (bytes.length >= 20 && view.getUint32(0, true) === GLB) {
    const size = view.getUint32(12, true);
    if (view.getUint32(16, true) !== JSON_CHUNK || size > bytes.length - 20) throw damaged;
    text = bytes.subarray(20, 20 + size);
    bin = 28 + size <= bytes.length ? 28 + size : 0;
  }
  try {
    const json = JSON.parse(new TextDecoder().decode(text).replace(/\0+$/, ''));
    if (json?.asset) return { json, bin };
  } catch {
    /* told below */
  }
  throw new LevelError(`${name} is not a glTF 2.0 scene.`);
}

export const gltfJson = (bytes, name) => openGltf(bytes, name).json;

/** The .vxs file that a scene holds or names by VXS_baked_shadows; null: none. beside: Map of URI to bytes */
function shadowsInside({ json, bin }, bytes, beside) {
  const { bufferView, uri } = json.extensions?.VXS_baked_shadows ?? {};
  if (typeof uri === 'string') return beside.get(uri) ?? null;
  const view = json.bufferViews?.[bufferView],
    buffer = json.buffers?.[view?.buffer];
  if (!buffer) return null;
  const data = buffer.uri ? beside.get(buffer.uri) : bin && bytes.subarray(bin);
  const at = view.byteOffset ?? 0;
  return data ? data.slice(at, at + view.byteLength) : null;
}

/** URIs of the files that a scene needs beside itself: { uri, kind: 'buffer' | 'image' | 'shadows' }. */
export function filesBeside(json) {
  const of = (list, kind) =>
    (list ?? [])
      .map(({ uri }) => ({ uri, kind }))
      .filter(({ uri }) => typeof uri === 'string' && !/^data:/i.test(uri));
  const shadows = [json.extensions?.VXS_baked_shadows ?? {}];
  return [...of(json.buffers, 'buffer'), ...of(json.images, 'image'), ...of(shadows, 'shadows')];
}

async function filesBelow(entry, folder = '') {
  if (entry.isFile) {
    const file = await new Promise((resolve, reject) => {
      entry.file(resolve, reject);
    });
    return [{ path: folder + file.name, file }];
  }
  const reader = entry.createReader(),
    found = [];
  for (;;) {
    // a reader gives at most a hundred entries at a time
    const some = await new Promise((resolve, reject) => {
      reader.readEntries(resolve, reject);
    });
    if (!some.length) return found;
    for (const each of some) found.push(...(await filesBelow(each, `${folder}${entry.name}/`)));
  }
}

/** Files of a drop or of a file dialog: [{ path, file }]; folders with all that is in them. */
export async function chosenFiles(transfer) {
  const entries = [...(transfer.items ?? [])].map((item) => item.webkitGetAsEntry?.()).filter(Boolean);
  if (entries.length) return (await Promise.all(entries.map((entry) => filesBelow(entry)))).flat();
  return [...transfer.files].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
}

/** The file for a URI of a scene in `folder`: at that path, else the only one with this name. */
function fileFor(uri, folder, files) {
  let path = uri.replaceAll('\\', '/');
  try {
    path = decodeURIComponent(path);
  } catch {
    /* a name with a percent sign */
  }
  const name = (text) => text.split('/').at(-1),
    named = files.filter((each) => name(each.path) === name(path));
  return (
    files.find((each) => each.path === folder + path.replace(/^(\.\/)+/, '')) ??
    (named.length === 1 ? named[0] : undefined)
  );
}

const bytesOf = async ({ file }) => new Uint8Array(await file.arrayBuffer());

/** The level of some files; what they lack comes from the level before. */
export async function droppedLevel(files, before) {
  const kind = (pattern) => files.filter(({ path }) => pattern.test(path));
  const scenes = kind(/\.(glb|gltf)$/i),
    assets = kind(/\.vxs$/i);
  if (scenes.length > 1)
    throw new LevelError(
      `Drop one scene at a time: there are ${scenes.map(({ path }) => path).join(' and ')}.`,
    );
  if (assets.length > 1)
    throw new LevelError(
      `Drop one .vxs file at a time: there are ${assets.map(({ path }) => path).join(' and ')}.`,
    );
  if (!scenes.length && !assets.length)
    throw new LevelError('Drop a scene, .glb or .gltf with its files, or a .vxs file, or both.');
  if (!scenes.length && !before)
    throw new LevelError(
      `Drop the scene of ${assets[0].path} as well: a .glb file, or a .gltf file with its files.`,
    );
  let asset = assets.length ? { name: assets[0].path, bytes: await bytesOf(assets[0]) } : null;
  if (!scenes.length) return { ...before, asset, warnings: [] };

  const [{ path }] = scenes,
    bytes = await bytesOf(scenes[0]),
    folder = path.replace(/[^/]*$/, ''),
    beside = new Map(),
    gltf = openGltf(bytes, path);
  for (const { uri, kind: what } of filesBeside(gltf.json)) {
    const found = fileFor(uri, folder, files);
    if (!found && what === 'buffer')
      throw new LevelError(`${path} needs the file ${uri}: drop both together.`);
    if (found) beside.set(uri, await bytesOf(found));
  }
  const inside = asset ? null : shadowsInside(gltf, bytes, beside);
  if (inside) asset = { name: `the shadows of ${path}`, bytes: inside };
  return { scene: { name: path, choice: null, bytes }, files: beside, asset, warnings: [] };
}
