// The settings beside the picture.
// SPDX-License-Identifier: MIT

/** An element: h('label', { class: 'row' }, 'text', child). Properties that begin with "on" are listeners. */
export function h(name, properties = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key.startsWith('on')) element.addEventListener(key.slice(2), value);
    else if (key === 'class' || key.startsWith('aria-')) element.setAttribute(key, value);
    else element[key] = value;
  }
  element.append(...children);
  return element;
}

const row = (name, ...children) => h('div', { class: 'row' }, h('span', {}, name), ...children);
const section = (name, open, ...children) =>
  h('details', { open }, h('summary', {}, name), h('div', { class: 'rows' }, ...children));

/** A slider with its value as text. */
function slider(name, { min, max, step, value, text, change }) {
  const shown = h('output', {}, text(value));
  const input = h('input', {
    type: 'range',
    min,
    max,
    step,
    value,
    'aria-label': name,
    oninput() {
      shown.value = text(Number(input.value));
      change(Number(input.value));
    },
  });
  const element = row(name, h('div', { class: 'slider' }, input, shown));
  return Object.assign(element, {
    input,
    set(to) {
      // without calling change
      input.value = to;
      shown.value = text(Number(input.value));
    },
  });
}

let groups = 0;
/** One of several: options is { value: text }. */
function choice(name, options, value, change) {
  const group = `choice-${++groups}`;
  const inputs = Object.entries(options).map(([key, text]) =>
    h(
      'label',
      {},
      h('input', {
        type: 'radio',
        name: group,
        value: key,
        checked: key === value,
        onchange: () => change(key),
      }),
      text,
    ),
  );
  const element = h(
    'div',
    { class: 'row', role: 'radiogroup', 'aria-label': name },
    h('span', {}, name),
    h('div', { class: 'choice' }, ...inputs),
  );
  element.set = (key) =>
    element.querySelectorAll('input').forEach((input) => {
      input.checked = input.value === key;
    });
  return element;
}

const check = (name, checked, change) => {
  const input = h('input', { type: 'checkbox', checked, onchange: () => change(input.checked) });
  return h('label', { class: 'row' }, h('span', {}, name), input);
};

export const bytesText = (bytes) =>
  bytes < 1000
    ? `${bytes} B`
    : bytes < 1024 * 1000
      ? `${(bytes / 1024).toFixed(1)} KiB`
      : `${(bytes / 1024 ** 2).toFixed(2)} MiB`;
export const countText = (count) => Math.round(count).toLocaleString('en');

function lightRow({ light, baked, on }, change) {
  const input = h('input', { type: 'checkbox', checked: on, onchange: () => change(input.checked) }),
    swatch = h('i');
  swatch.style.background = `#${light.color.getHexString()}`;
  const unit = light.isDirectionalLight ? 'lx' : 'cd',
    amount = light.intensity >= 100 ? light.intensity.toFixed(0) : light.intensity.toPrecision(3);
  return h(
    'label',
    { title: baked ? `${baked.resolution} x ${baked.resolution} texels` : 'no baked shadow' },
    input,
    swatch,
    h('span', {}, light.userData.name || light.name || light.parent?.name || 'light'),
    h('small', {}, baked ? `${amount} ${unit}` : 'no shadow'),
  );
}

function lightsSection(state, act) {
  const list = h('div', { class: 'lights' });
  const fill = () =>
    list.replaceChildren(...state.lights.map((each) => lightRow(each, (on) => act.light(each, on))));
  const all = (on) => {
    for (const each of state.lights) act.light(each, on);
    fill();
  };
  fill();
  const several =
    state.lights.length > 1
      ? [
          h(
            'div',
            { class: 'buttons' },
            h('button', { type: 'button', onclick: () => all(true) }, 'All on'),
            h('button', { type: 'button', onclick: () => all(false) }, 'All off'),
          ),
        ]
      : [];
  return section(
    state.lights.length === 1 ? 'Light' : `Lights (${state.lights.length})`,
    true,
    state.lights.length ? list : h('p', { class: 'note' }, 'The level has no lights.'),
    ...several,
  );
}

function shadowSection(state, act) {
  const widthText = (k) => `${k} x ${k}`;
  const width = slider('Filter', {
    min: 1,
    max: 17,
    step: state.filter.smooth ? 1 : 2,
    value: state.filter.smooth ?? state.filter.box,
    text: widthText,
    change: act.width,
  });
  const kind = choice(
    'Taps',
    { box: 'Box', smooth: 'Smooth' },
    state.filter.smooth ? 'smooth' : 'box',
    (key) => {
      width.input.step = key === 'box' ? 2 : 1;
      width.set(width.input.value);
      act.kind(key, Number(width.input.value));
    },
  );
  const compare = choice(
    'Compare',
    { off: 'Off', live: 'Live 2048', none: 'None' },
    state.compare ?? 'off',
    act.compare,
  );
  return Object.assign(section('Shadows', true, width, kind, compare), { compare });
}

function fogSection({ on, extinction, radius }, act) {
  const middle = Math.log10(0.05 / radius),
    perMetre = (power) => 10 ** power;
  return section(
    'Fog',
    on,
    check('Fog', on, act.fog),
    slider('Density', {
      min: middle - 1.5,
      max: middle + 1.5,
      step: 0.01,
      value: Math.log10(extinction),
      text: (power) => `${perMetre(power).toPrecision(2)}/m`,
      change: (power) => act.density(perMetre(power)),
    }),
    h(
      'p',
      { class: 'note' },
      'The lit parts of each ray are read from the file, exactly: no steps, no noise.',
    ),
  );
}

function cameraSection(state, act) {
  const list = h(
    'select',
    { 'aria-label': 'Camera', onchange: () => act.camera(Number(list.value)) },
    h('option', { value: -1 }, 'Whole level'),
    ...state.cameras.map(({ name }, n) => h('option', { value: n }, name)),
  );
  return section(
    'Camera',
    true,
    row('View', list),
    slider('Speed', {
      min: -3,
      max: 3,
      step: 0.1,
      value: 0,
      text: (power) => `${(2 ** power).toFixed(2)} x`,
      change: act.speed,
    }),
    h('div', { class: 'buttons' }, h('button', { type: 'button', onclick: act.walk }, 'Walk (F)')),
    h(
      'p',
      { class: 'note' },
      'Drag to turn, right drag to move, scroll to come closer. Walking: W A S D, Q and E down and up, Shift for fast, Escape to stop.',
    ),
  );
}

/** Numbers of the level: { name: text }. */
export function facts(entries) {
  return h(
    'dl',
    {},
    ...Object.entries(entries).flatMap(([name, text]) => [h('dt', {}, name), h('dd', {}, text)]),
  );
}

/**
 * Fill the panel. state: { lights, filter, compare, cameras, stops, sky, fog, warnings }; act: functions for each change.
 * Returns { compare, numbers }: the choice, which has set(), and the element for numbers.
 */
export function buildPanel(panel, state, act) {
  const shadows = shadowSection(state, act),
    numbers = h('div');
  const warnings = state.warnings.length
    ? h('ul', { class: 'warnings' }, ...state.warnings.map((text) => h('li', {}, text)))
    : h('p', { class: 'note' }, 'None.');
  const fog = state.fog ? [fogSection(state.fog, act)] : [];
  panel.replaceChildren(
    shadows,
    lightsSection(state, act),
    ...fog,
    section('Numbers', true, numbers),
    cameraSection(state, act),
    section(
      'Picture',
      false,
      slider('Exposure', {
        min: -5,
        max: 5,
        step: 0.1,
        value: state.stops,
        text: (stops) => `${stops > 0 ? '+' : ''}${stops.toFixed(1)}`,
        change: act.exposure,
      }),
      slider('Sky light', {
        min: 0,
        max: 2,
        step: 0.02,
        value: state.sky,
        text: (share) => `${Math.round(100 * share)} %`,
        change: act.sky,
      }),
      h(
        'div',
        { class: 'buttons' },
        h('button', { type: 'button', onclick: act.measure }, 'Measure exposure'),
      ),
      h('p', { class: 'note' }, 'The light of the sky is not baked: it reaches every surface.'),
    ),
    section(`Warnings (${state.warnings.length})`, state.warnings.length > 0, warnings),
    section(
      'Files',
      false,
      h('div', { class: 'buttons' }, h('button', { type: 'button', onclick: act.open }, 'Open files')),
      h(
        'p',
        { class: 'note' },
        'Or drop them here: a .glb or .gltf with its files, and its .vxs. Nothing leaves this computer.',
      ),
      h(
        'p',
        { class: 'note' },
        'Made with three.js and meshoptimizer (MIT), Draco and Basis Universal (Apache 2.0).',
      ),
    ),
  );
  return { compare: shadows.compare, numbers };
}
