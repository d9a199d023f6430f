// `vxs/gltf-transform`: the extension VXS_baked_shadows for glTF-Transform 4, so that a pipeline keeps baked shadows.
//
//     const io = new NodeIO().registerExtensions([...ALL_EXTENSIONS, VXSBakedShadows]);
//     const document = await io.read('level.glb');
//     embedShadows(document, await readFile('level.vxs'));
//     await io.write('lit.glb', document);
// SPDX-License-Identifier: MIT
import { Extension, ExtensionProperty, PropertyType } from '@gltf-transform/core';

const NAME = 'VXS_baked_shadows';
const GLB_BUFFER = '@glb.bin';

/** The bytes of a .vxs file, or the URI of one; a property of the root. */
export class Shadows extends ExtensionProperty {
  static EXTENSION_NAME = NAME;

  init() {
    this.extensionName = NAME;
    this.propertyType = 'BakedShadows';
    this.parentTypes = [PropertyType.ROOT];
  }

  getDefaults() { return Object.assign(super.getDefaults(), { bytes: null, uri: '' }); }
  getBytes() { return this.get('bytes'); }
  setBytes(bytes) { return this.set('bytes', bytes && new Uint8Array(bytes)).set('uri', ''); }
  getURI() { return this.get('uri'); }
  setURI(uri) { return this.set('uri', uri).set('bytes', null); }
}

const own = (document) => {
  const shadows = document.getRoot().getExtension(NAME);
  return shadows && (shadows.getBytes() || shadows.getURI()) ? shadows : null;
};

export class VXSBakedShadows extends Extension {
  static EXTENSION_NAME = NAME;
  extensionName = NAME;
  prewriteTypes = [PropertyType.BUFFER];

  createShadows() { return new Shadows(this.document.getGraph()); }

  read(context) {
    const { json, resources } = context.jsonDoc, found = json.extensions?.[NAME];
    if (!found) return this;
    const shadows = this.createShadows();
    if (found.bufferView !== undefined) {
      const { buffer, byteOffset = 0, byteLength } = json.bufferViews[found.bufferView];
      const bytes = resources[json.buffers[buffer].uri ?? GLB_BUFFER];
      shadows.setBytes(bytes.slice(byteOffset, byteOffset + byteLength));
    } else shadows.setURI(found.uri ?? '');
    this.document.getRoot().setExtension(NAME, shadows);
    return this;
  }

  prewrite(context) {
    const bytes = own(this.document)?.getBytes();
    if (!bytes) return this;
    const buffer = this.document.getRoot().listBuffers()[0] ?? this.document.createBuffer();
    const views = context.otherBufferViews.get(buffer) ?? [];
    context.otherBufferViews.set(buffer, [...views, bytes]);
    return this;
  }

  write(context) {
    const shadows = own(this.document);
    if (!shadows) return this;
    const { json } = context.jsonDoc, bytes = shadows.getBytes();
    json.extensions = { ...json.extensions, [NAME]: bytes ? { bufferView: context.otherBufferViewsIndexMap.get(bytes) } : { uri: shadows.getURI() } };
    return this;
  }
}

/** Put the bytes of a .vxs file into a document. */
export function embedShadows(document, bytes) {
  const shadows = document.createExtension(VXSBakedShadows).createShadows().setBytes(bytes);
  document.getRoot().setExtension(NAME, shadows);
  return shadows;
}

/** The bytes of the .vxs file in a document; null without one. */
export const shadowsOf = (document) => own(document)?.getBytes() ?? null;
