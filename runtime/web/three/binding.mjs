// SPDX-License-Identifier: MIT
import { Node } from 'three/webgpu';

/** Declares a texture by its name, so that native code can read it. */
export class Binding extends Node {
  constructor(node) {
    super('void');
    this.node = node;
  }

  generate(builder) {
    this.node.build(builder, 'property');
    return '';
  }
}
