// Ways to look at a level: around it, through it on foot or in flight, and from the file's cameras.
// SPDX-License-Identifier: MIT
import { Euler, Sphere, Vector3 } from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

const MOVES = {
  KeyW: [0, 0, -1],
  ArrowUp: [0, 0, -1],
  KeyS: [0, 0, 1],
  ArrowDown: [0, 0, 1],
  KeyA: [-1, 0, 0],
  ArrowLeft: [-1, 0, 0],
  KeyD: [1, 0, 0],
  ArrowRight: [1, 0, 0],
  KeyE: [0, 1, 0],
  Space: [0, 1, 0],
  KeyQ: [0, -1, 0],
};
const TURN = 0.0022; // radians for a pixel of the mouse

export class Cameras {
  #held = new Set();

  /** changed()  called when the camera has moved, or will move in the next frame;   mode(name)  'orbit' or 'walk' */
  constructor(camera, canvas, changed, mode) {
    Object.assign(this, { camera, canvas, changed, mode });
    this.orbit = new OrbitControls(camera, canvas);
    Object.assign(this.orbit, {
      enableDamping: true,
      dampingFactor: 0.12,
      zoomToCursor: true,
      screenSpacePanning: true,
    });
    this.orbit.addEventListener('change', changed);
    this.walking = false;
    this.speed = 1;
    canvas.ownerDocument.addEventListener('pointerlockchange', () => {
      if (!this.#isLocked()) this.#stop();
    });
    canvas.ownerDocument.addEventListener('mousemove', (event) => this.#turn(event));
    canvas.ownerDocument.addEventListener('keydown', (event) => this.#key(event, true));
    canvas.ownerDocument.addEventListener('keyup', (event) => this.#key(event, false));
    canvas.ownerDocument.defaultView.addEventListener('blur', () => this.#held.clear());
  }

  #isLocked() {
    return this.canvas.ownerDocument.pointerLockElement === this.canvas;
  }

  /**
   * Look at a level: from inside if it is a building without an outside, else from above, beside the sun.
   * around  what is around points: Picker.around;   sun  direction to it, or null
   */
  frame(bounds, sun, around) {
    const sphere = bounds.getBoundingSphere(new Sphere()),
      radius = Math.max(sphere.radius, 1e-3),
      { camera, orbit } = this;
    this.radius = radius;
    this.centre = sphere.center;
    this.speed = radius / 8;
    camera.fov = 45;
    const inside = this.#inside(bounds, around);
    if (inside) {
      camera.position.copy(inside.eye);
      orbit.target.copy(inside.target);
    } else {
      const side = sun && Math.hypot(sun.x, sun.z) > 0.05 ? Math.atan2(sun.z, sun.x) + 1.05 : 0.9,
        up = 0.36;
      const from = new Vector3(Math.cos(side) * Math.cos(up), Math.sin(up), Math.sin(side) * Math.cos(up));
      this.#fit(bounds, from);
    }
    orbit.maxDistance = 20 * radius;
    this.#near();
    orbit.update();
    this.changed();
  }

  /** The nearest place in a direction from which all of a box is seen; `from` is a unit vector to it. */
  #fit(bounds, from) {
    const { camera, orbit } = this,
      centre = bounds.getCenter(new Vector3()),
      tan = Math.tan((camera.fov * Math.PI) / 360);
    const right = new Vector3(0, 1, 0).cross(from).normalize(),
      up = new Vector3().crossVectors(from, right);
    let distance = 0;
    for (let n = 0; n < 8; n++) {
      const corner = new Vector3(
        ...['x', 'y', 'z'].map((axis, bit) => ((n >> bit) & 1 ? bounds.max : bounds.min)[axis]),
      ).sub(centre);
      const across = Math.max(Math.abs(corner.dot(up)), Math.abs(corner.dot(right)) / camera.aspect);
      distance = Math.max(distance, corner.dot(from) + across / (0.92 * tan));
    }
    camera.position.copy(centre).addScaledVector(from, distance);
    orbit.target.copy(centre);
  }

  /** A place inside and one to look at, { eye, target }, of a level that shuts out the sky where there is most room; else null. */
  #inside(bounds, around) {
    const size = bounds.getSize(new Vector3()),
      points = [];
    for (let n = 0; n < 18; n++)
      points.push(
        new Vector3((n % 3) + 1, 1 + 1.2 * Math.floor(n / 9), (Math.floor(n / 3) % 3) + 1)
          .divideScalar(4)
          .multiply(size)
          .add(bounds.min),
      );
    const places = around(points).map((rays, n) => {
      const hits = rays.map(({ distance }) => distance).filter((distance) => distance < Infinity);
      hits.sort((a, b) => a - b);
      return { eye: points[n], rays, share: hits.length / rays.length, room: hits[hits.length >> 1] ?? 0 };
    });
    const shares = places.map(({ share }) => share).sort((a, b) => a - b);
    if (shares[shares.length >> 1] < 0.9) return null; // the sky is seen from most places
    const best = places.filter(({ share }) => share > 0.9).reduce((a, b) => (b.room > a.room ? b : a));
    // the way with most room about it, so that no gap in a wall is taken
    const room = (towards) => {
      const near = best.rays
        .filter(({ direction }) => direction.dot(towards) > 0.8)
        .map(({ distance }) => Math.min(distance, 8 * best.room));
      return near.reduce((sum, distance) => sum + distance, 0) / near.length;
    };
    const level = best.rays
      .filter(({ direction }) => Math.abs(direction.y) < 0.15)
      .map(({ direction, distance }) => ({ direction, distance, free: room(direction) }));
    const ahead = level.reduce((a, b) => (b.free > a.free ? b : a)),
      back = level.reduce((a, b) =>
        b.direction.dot(ahead.direction) < a.direction.dot(ahead.direction) ? b : a,
      );
    return {
      eye: best.eye.clone().addScaledVector(back.direction, 0.6 * Math.min(back.distance, back.free)),
      target: best.eye
        .clone()
        .addScaledVector(ahead.direction, 0.5 * Math.min(ahead.distance, ahead.free))
        .sub(new Vector3(0, 0.08 * ahead.free, 0)),
    };
  }

  #near() {
    const distance = this.camera.position.distanceTo(this.centre);
    const far = distance + 2.2 * this.radius,
      near = Math.max(far / 50000, Math.min(0.02 * this.radius, 0.5 * (distance - 1.1 * this.radius)));
    const least = Math.max(far / 50000, Math.min(0.05, this.radius / 500));
    Object.assign(this.camera, { near: Math.max(near, least), far });
    this.camera.updateProjectionMatrix();
  }

  /** Look from a camera of the file. */
  use(camera) {
    camera.updateWorldMatrix(true, false);
    const towards = new Vector3();
    camera.getWorldDirection(towards);
    this.camera.position.setFromMatrixPosition(camera.matrixWorld);
    if (camera.isPerspectiveCamera) this.camera.fov = camera.fov;
    this.look(this.camera.position.clone().add(towards.multiplyScalar(this.radius / 2)));
  }

  /** Look from where the camera is. */
  look(target) {
    this.orbit.target.copy(target);
    this.#near();
    this.orbit.update();
    this.changed();
  }

  /** Walk: WASD, and the mouse, which the page takes until Escape. */
  walk() {
    this.walking = true;
    this.orbit.enabled = false;
    this.mode('walk');
    try {
      this.canvas.requestPointerLock()?.catch?.(() => {}); // without it, dragging turns
    } catch {
      /* the same */
    }
  }

  #stop() {
    if (!this.walking) return;
    this.walking = false;
    this.#held.clear();
    this.orbit.enabled = true;
    const ahead = this.camera.getWorldDirection(new Vector3());
    this.look(this.camera.position.clone().addScaledVector(ahead, this.radius / 2));
    this.mode('orbit');
  }

  stop() {
    if (this.#isLocked()) this.canvas.ownerDocument.exitPointerLock();
    this.#stop();
  }

  #turn({ movementX, movementY, buttons }) {
    if (!this.walking || !(this.#isLocked() || buttons)) return;
    const angles = new Euler().setFromQuaternion(this.camera.quaternion, 'YXZ');
    angles.y -= TURN * movementX;
    angles.x = Math.max(-1.55, Math.min(1.55, angles.x - TURN * movementY));
    this.camera.quaternion.setFromEuler(angles);
    this.changed();
  }

  #key(event, down) {
    if (!this.walking || !MOVES[event.code]) {
      if (this.walking && down && event.code === 'Escape') this.stop();
      return;
    }
    event.preventDefault();
    if (down) this.#held.add(event.code);
    else this.#held.delete(event.code);
    this.fast = event.shiftKey;
    this.changed();
  }

  /** Once a frame. Returns 1 while the camera moves. */
  update(seconds) {
    if (!this.walking) return this.orbit.update() ? 1 : 0;
    const step = new Vector3();
    for (const key of this.#held) step.add(new Vector3(...MOVES[key]));
    if (step.lengthSq() === 0) return 0;
    const { y } = step;
    step
      .setY(0)
      .applyQuaternion(this.camera.quaternion)
      .setY(step.y + y)
      .normalize();
    this.camera.position.addScaledVector(step, this.speed * (this.fast ? 4 : 1) * Math.min(seconds, 0.1));
    this.#near();
    return 1;
  }
}

/** Cameras of a file: [{ name, camera }]. */
export function camerasOf(root) {
  const found = [];
  root.traverse((object) => {
    if (object.isCamera)
      found.push({ name: object.name || object.parent?.name || `camera ${found.length}`, camera: object });
  });
  return found;
}
