// SPDX-License-Identifier: MIT
import type { Document, Extension, ExtensionProperty } from '@gltf-transform/core';

/** Baked shadows of a document: the bytes of a .vxs file, or the URI of one. A property of the root. */
export class Shadows extends ExtensionProperty {
  readonly extensionName: 'VXS_baked_shadows';
  readonly propertyType: string;
  readonly parentTypes: string[];
  protected init(): void;
  getBytes(): Uint8Array | null;
  setBytes(bytes: Uint8Array | ArrayBuffer): this;
  getURI(): string;
  setURI(uri: string): this;
}

/** The extension VXS_baked_shadows: register it with the I/O class, and reading, transforming and writing keep the bytes. */
export class VXSBakedShadows extends Extension {
  static readonly EXTENSION_NAME: 'VXS_baked_shadows';
  readonly extensionName: 'VXS_baked_shadows';
  createShadows(): Shadows;
  read(context: unknown): this;
  write(context: unknown): this;
}

/** Put the bytes of a .vxs file into a document; they are copied. */
export function embedShadows(document: Document, bytes: Uint8Array | ArrayBuffer): Shadows;

/** The bytes of the .vxs file in a document; null without one. */
export function shadowsOf(document: Document): Uint8Array | null;
