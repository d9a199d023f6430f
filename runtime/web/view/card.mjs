// What is shown of the texel under the cursor: a card of text, its outline, and the way to its caster.
// SPDX-License-Identifier: MIT
import { BufferGeometry, Float32BufferAttribute, Line, LineBasicMaterial, LineLoop, Vector3 } from 'three';
import { h } from './panel.mjs';
import { explain, outlineOf, towardsLight } from './texel.mjs';

const WORDS = { lit: 'Lit', shadow: 'In shadow', away: 'Faces away', outside: 'Outside of the map' };

function line(Kind, places, color) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new Float32BufferAttribute(places.flat(), 3));
  const look = { color, depthTest: false, transparent: true, opacity: 0.9, toneMapped: false };
  return Object.assign(new Kind(geometry, new LineBasicMaterial(look)), { frustumCulled: false });
}

export class TexelCard {
  /** stage: a Stage, whose marks are drawn;   output: the element for the text */
  constructor(stage, output) {
    Object.assign(this, { stage, output, told: null });
  }

  /** Of all lights that are on, the one that gives a surface most light if nothing is between. */
  #lightAt({ point, normal }) {
    const at = new Vector3(...point),
      strength = ({ light, baked }) => {
        const place = new Vector3().setFromMatrixPosition(light.matrixWorld);
        const falls = light.isDirectionalLight ? 1 : 1 / Math.max(place.distanceToSquared(at), 1e-6);
        const facing = towardsLight(baked, point).dot(new Vector3(...normal));
        return light.intensity * falls * Math.max(facing, 1e-6);
      };
    const shining = this.stage.lights.filter(({ on, baked }) => on && baked);
    return shining.sort((a, b) => strength(b) - strength(a))[0]?.baked;
  }

  /** Tell of a surface, { point, normal } of Picker.at; null: of none. */
  tell(surface) {
    const { stage, output } = this,
      baked = surface && this.#lightAt(surface);
    this.clear();
    if (!baked) return;
    const told = explain(baked, surface.point, surface.normal, stage.filter),
      dot = h('i');
    const share = told.state === 'away' ? 0 : Math.max(told.lit, 0);
    dot.style.setProperty('--share', `hsl(42 90% ${8 + 58 * share}%)`);
    const map = baked.maps > 1 ? `, map ${told.map}` : '';
    const where = told.texel ? `${map}: texel ${told.texel.join(', ')}, depth ${told.depth}` : '';
    const state = WORDS[told.state] ?? `${Math.round(100 * told.lit)} % lit`;
    output.replaceChildren(
      h('div', { class: 'state' }, dot, h('b', {}, state)),
      h('p', { class: 'why' }, told.why),
      h('p', {}, told.light + where),
      h('p', {}, `at ${surface.point.map((value) => value.toFixed(2)).join(', ')} m`),
    );
    output.hidden = false;
    this.told = { ...told, ...surface, filter: stage.filter };
    if (told.texel) stage.marks.add(line(LineLoop, outlineOf(baked, told), 0xffd27a));
    if (told.caster) stage.marks.add(line(Line, [surface.point, told.caster], 0xff8d7a));
  }

  clear() {
    this.told = null;
    this.output.hidden = true;
    for (const mark of [...this.stage.marks.children]) {
      mark.geometry.dispose();
      mark.material.dispose();
      mark.removeFromParent();
    }
  }
}
