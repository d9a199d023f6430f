// The page of vxs view: a level in its baked light.
// SPDX-License-Identifier: MIT
import { Vector3 } from 'three';
import { VXSError, load } from 'vxs';
import { VXSLoader } from 'vxs/three';
import runtimeWasm from 'packed:vxs/runtime/vxs.wasm';
import { Cameras, camerasOf } from './cameras.mjs';
import { TexelCard } from './card.mjs';
import { shadowPasses } from './costs.mjs';
import { LevelError, chosenFiles, droppedLevel, embeddedLevel } from './level.mjs';
import { numbersOf, subtitleOf, warningsOf } from './figures.mjs';
import { buildPanel, facts, h } from './panel.mjs';
import { readScene } from './scene.mjs';
import { LIVE_LIGHTS, LIVE_SIDE_PX, Stage } from './stage.mjs';
import { Picker } from './texel.mjs';
import { unpack } from './unpack.mjs';

const byId = (id) => document.getElementById(id);
const canvas = byId('canvas'),
  split = byId('split'),
  panel = byId('panel');

class View {
  constructor() {
    this.stage = new Stage(canvas);
    this.cameras = new Cameras(
      this.stage.camera,
      canvas,
      () => this.redraw(),
      (mode) => this.#mode(mode),
    );
    this.picker = new Picker(this.stage.renderer);
    this.card = new TexelCard(this.stage, byId('texel'));
    this.runtime = unpack(runtimeWasm).then((wasm) => load({ wasm }));
    this.level = null;
    this.pointer = null;
    new ResizeObserver(() => this.#resize()).observe(byId('stage'));
    this.#resize();
    this.#listen();
  }

  redraw() {
    if (this.pending) return;
    this.pending = requestAnimationFrame((now) => this.#frame(now));
  }

  #frame(now) {
    this.pending = 0;
    if (!this.level) return;
    const moving = this.cameras.update((now - (this.before ?? now)) / 1000);
    this.before = moving ? now : undefined;
    if (this.pointerMoved && !moving) this.#readTexel();
    this.stage.render();
    this.#numbers();
    if (moving) this.redraw();
  }

  #resize() {
    const { width, height } = byId('stage').getBoundingClientRect();
    this.stage.resize(width, height, Math.min(devicePixelRatio, 2));
    this.#placeSplit();
    this.redraw();
  }

  // --- levels ------------------------------------------------------------------------------------------------------------------

  async open(level) {
    const begin = performance.now(),
      runtime = await this.runtime,
      loader = new VXSLoader().setRuntime(runtime);
    let shadows = null,
      asset = null;
    const opening = performance.now();
    if (level.asset) {
      try {
        shadows = await loader.parseAsync(level.asset.bytes);
      } catch (error) {
        throw error instanceof VXSError
          ? new LevelError(`${level.asset.name} cannot be opened: ${error.message}.`)
          : error;
      }
      asset = shadows.asset;
    }
    const opened = performance.now();
    try {
      const { gltf, root, missing } = await readScene(
        level,
        this.stage.renderer,
        asset?.info?.scene?.name || null,
      );
      const parsed = performance.now();
      Object.assign(this, {
        level,
        asset,
        root,
        times: { runtime: opening - begin, asset: opened - opening, scene: parsed - opened },
      });
      if (document.body.classList.contains('empty')) {
        // the panel appears, where there is room for it
        document.body.classList.remove('empty');
        if (matchMedia('(max-width: 760px)').matches) this.#togglePanel();
        this.#resize();
      }
      this.#show(gltf, root, shadows, missing);
    } catch (error) {
      if (this.stage.shadows !== shadows) shadows?.dispose();
      throw error;
    }
  }

  #show(gltf, root, shadows, missing) {
    const { stage, cameras, level } = this;
    this.card.clear();
    const match = stage.show(root, gltf, shadows);
    const sun = stage.lights.find(({ light }) => light.isDirectionalLight)?.light;
    const towards =
      sun &&
      new Vector3()
        .setFromMatrixPosition(sun.matrixWorld)
        .sub(new Vector3().setFromMatrixPosition(sun.target.matrixWorld))
        .normalize();
    this.frame = () =>
      cameras.frame(stage.bounds, towards, (points) => this.picker.around(stage.scene, points));
    this.frame();
    this.fileCameras = camerasOf(root);
    if (this.fileCameras.length) cameras.use(this.fileCameras[0].camera);
    stage.measure();
    this.passes = shadowPasses(
      root,
      stage.lights.map(({ light }) => light),
      stage.bounds.getSize(new Vector3()).length(),
    );

    document.title = `${level.scene.name} - vxs view`;
    byId('title').querySelector('h1').textContent = level.scene.name;
    byId('title').querySelector('p').textContent = subtitleOf(level, stage);
    this.#panel(warningsOf(level, stage, missing, match.added));
    this.redraw();
  }

  #panel(warnings) {
    const { stage, cameras } = this;
    const changed =
      (change) =>
      (...values) => {
        change(...values);
        this.redraw();
      };
    this.controls = buildPanel(
      panel,
      {
        lights: stage.lights,
        filter: stage.filter,
        compare: stage.compare,
        cameras: this.fileCameras,
        stops: stage.exposureStops,
        sky: stage.skyShare,
        fog: stage.fog.available ? stage.fog : null,
        warnings,
      },
      {
        light: changed((each, on) => {
          each.on = on;
        }),
        width: changed((width) => {
          stage.filter = stage.filter.smooth ? { smooth: width } : { box: width };
        }),
        kind: changed((kind, width) => {
          stage.filter = { [kind]: width };
        }),
        fog: changed((on) => {
          stage.fog.on = on;
          stage.measure();
        }),
        density: changed((extinction) => {
          stage.fog.extinction = extinction;
        }),
        compare: (key) => this.compare(key === 'off' ? null : key),
        camera: (n) => (n < 0 ? this.frame() : cameras.use(this.fileCameras[n].camera)),
        speed: (power) => {
          cameras.speed = (stage.bounds.getSize(new Vector3()).length() / 16) * 2 ** power;
        },
        walk: () => cameras.walk(),
        exposure: changed((stops) => {
          stage.exposureStops = stops;
        }),
        sky: changed((share) => {
          stage.skyShare = share;
        }),
        measure: changed(() => stage.measure()),
        open: () => this.#chooseFiles(),
      },
    );
    this.numbersText = '';
    this.#numbers();
  }

  #numbers() {
    const entries = numbersOf(this.level, this.stage, this.times, this.passes);
    const text = JSON.stringify(entries);
    if (text === this.numbersText) return;
    this.numbersText = text;
    this.controls.numbers.replaceChildren(facts(entries));
  }

  // --- the line between halves -------------------------------------------------------------------------------------------------

  compare(key) {
    this.stage.compare = key;
    this.controls?.compare.set(key ?? 'off');
    split.hidden = !key;
    this.#placeSplit();
    this.redraw();
  }

  #placeSplit() {
    const { stage } = this,
      baked = stage.lights.find((each) => each.baked)?.baked,
      { smooth, box } = stage.filter;
    split.style.left = `${100 * stage.split}%`;
    split.setAttribute('aria-valuenow', Math.round(100 * stage.split));
    byId('split-left').textContent = baked
      ? `Baked ${baked.resolution}, ${smooth ?? box} x ${smooth ?? box}`
      : 'Nothing baked';
    const live = stage.lights.filter(({ on }) => on).length;
    byId('split-right').textContent =
      stage.compare === 'none'
        ? 'No shadows'
        : `Live ${LIVE_SIDE_PX}, PCF${live > LIVE_LIGHTS ? `, ${LIVE_LIGHTS} of ${live} lights` : ''}`;
  }

  #moveSplit(share) {
    this.stage.split = Math.min(Math.max(share, 0), 1);
    this.#placeSplit();
    this.redraw();
  }

  #readTexel() {
    const { stage, picker, pointer, card } = this,
      { width, height } = canvas.getBoundingClientRect();
    this.pointerMoved = false;
    if (!pointer || this.cameras.walking) return card.clear();
    const [x, y, wide, high] = [pointer.x, pointer.y, width, height].map(Math.floor);
    return card.tell(picker.at(stage.scene, stage.camera, x, y, wide, high));
  }

  // --- events ------------------------------------------------------------------------------------------------------------------

  #mode(mode) {
    canvas.classList.toggle('walk', mode === 'walk');
    byId('hint').textContent = mode === 'walk' ? 'W A S D to walk, the mouse to look, Escape to stop' : '';
  }

  #listen() {
    canvas.addEventListener('pointermove', (event) => {
      const box = canvas.getBoundingClientRect();
      this.pointer = event.buttons ? null : { x: event.clientX - box.left, y: event.clientY - box.top };
      this.pointerMoved = true;
      this.redraw();
    });
    canvas.addEventListener('click', (event) => {
      const box = canvas.getBoundingClientRect();
      this.pointer = { x: event.clientX - box.left, y: event.clientY - box.top };
      this.pointerMoved = true;
      this.redraw();
    });
    canvas.addEventListener('pointerleave', (event) => {
      if (event.pointerType === 'touch') return; // what was tapped stays
      this.pointer = null;
      this.pointerMoved = true;
      this.redraw();
    });
    canvas.addEventListener('webglcontextrestored', () => {
      this.stage.restored();
      this.redraw();
    });

    const drag = (event) =>
      this.#moveSplit(
        (event.clientX - byId('stage').getBoundingClientRect().left) / byId('stage').clientWidth,
      );
    split.addEventListener('pointerdown', (event) => split.setPointerCapture(event.pointerId));
    split.addEventListener('pointermove', (event) => {
      if (split.hasPointerCapture(event.pointerId)) drag(event);
    });
    split.addEventListener('keydown', (event) => {
      const by = { ArrowLeft: -0.02, ArrowRight: 0.02, Home: -1, End: 1 }[event.key];
      if (by) this.#moveSplit(this.stage.split + by);
      if (by) event.preventDefault();
    });

    byId('open').addEventListener('click', () => this.#chooseFiles());
    byId('toggle').addEventListener('click', () => this.#togglePanel());
    document.addEventListener('keydown', (event) => {
      if (
        event.ctrlKey ||
        event.metaKey ||
        event.altKey ||
        /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) ||
        this.cameras.walking ||
        !this.level
      )
        return;
      if (event.key === 'f') this.cameras.walk();
      if (event.key === 'p') this.#togglePanel();
      if (event.key === 'c') this.compare({ null: 'live', live: 'none', none: null }[this.stage.compare]);
    });

    const drop = byId('drop');
    let entered = 0;
    const over = (by) => {
      entered = by ? entered + by : 0;
      drop.hidden = !!this.level && entered <= 0;
    };
    addEventListener('dragenter', () => over(1));
    addEventListener('dragleave', () => over(-1));
    addEventListener('dragover', (event) => event.preventDefault());
    addEventListener('drop', (event) => {
      event.preventDefault();
      over(0);
      this.take(event.dataTransfer);
    });
  }

  #togglePanel() {
    panel.hidden = !panel.hidden;
    byId('toggle').setAttribute('aria-expanded', String(!panel.hidden));
  }

  #chooseFiles() {
    const input = h('input', { type: 'file', multiple: true, onchange: () => this.take(input) });
    input.click();
  }

  /** Files of a drop or a dialog. */
  take(transfer) {
    return this.attempt(
      chosenFiles(transfer)
        .then((files) => droppedLevel(files, this.level))
        .then((level) => this.open(level)),
    );
  }

  /** Await work, and say what went wrong. */
  async attempt(work) {
    byId('hint').textContent = 'Reading the level';
    try {
      await work;
      byId('drop').hidden = !!this.level;
    } catch (error) {
      if (!(error instanceof LevelError)) console.error(error);
      byId('message').querySelector('p').textContent = error.message;
      byId('message').showModal();
      byId('drop').hidden = !!this.level;
    }
    byId('hint').textContent = '';
  }
}

function start() {
  document.body.classList.add('empty');
  let view;
  try {
    view = new View();
  } catch (error) {
    byId('message').querySelector('p').textContent = `This browser cannot draw the level: ${error.message}`;
    byId('message').showModal();
    return;
  }
  globalThis.vxsView = view; // for tests
  view.ready = view.attempt(embeddedLevel(document).then((level) => (level ? view.open(level) : undefined)));
}

start();
