// Baked shadows that a glTF file names or holds.
// SPDX-License-Identifier: MIT
import { LoaderUtils } from 'three';
import { VXSError } from 'vxs';

export const EXTENSION = 'VXS_baked_shadows';
const EXTRA = 'vxs_shadows';

/**
 * A plugin of GLTFLoader: loader.register((parser) => new VXSShadowsPlugin(parser)). The result has `shadows`: BakedShadows, or null.
 * They come from the extension VXS_baked_shadows (a buffer view or a URI), or from extras.vxs_shadows of the file or of its scene
 * (a URI). A file that cannot be read fails the whole load.
 */
export class VXSShadowsPlugin {
  constructor(parser, loader = new this.constructor.Loader(parser.options.manager)) {
    this.name = EXTENSION;
    this.parser = parser;
    this.loader = loader;
  }

  async afterRoot(result) {
    const { json, options } = this.parser, { bufferView, uri } = json.extensions?.[EXTENSION] ?? {};
    const named = uri ?? json.extras?.[EXTRA] ?? json.scenes?.[json.scene ?? 0]?.extras?.[EXTRA];
    if (bufferView !== undefined) {
      const view = json.bufferViews?.[bufferView];
      if (!view || uri !== undefined) throw new VXSError('argument', `${EXTENSION} has to name one buffer view, or one URI`);
      result.shadows = await this.loader.parseAsync(await this.parser.getDependency('bufferView', bufferView));
    } else result.shadows = typeof named === 'string' ? await this.loader.loadAsync(LoaderUtils.resolveURL(named, options.path)) : null;
  }
}
