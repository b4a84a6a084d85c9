// Dragging the platform: in the plane of the picture, or with Shift (or the right button) turning it.
import * as THREE from "three";

export class PlatformDrag {
  constructor(drawing, solver, { itemAt, onMove }) {
    Object.assign(this, { drawing, solver, onMove });
    this.held = null;
    const canvas = drawing.canvas;
    canvas.addEventListener("pointerdown", (event) => this._begin(event, itemAt), { capture: true });
    canvas.addEventListener("pointermove", (event) => this._move(event));
    for (const kind of ["pointerup", "pointercancel"]) canvas.addEventListener(kind, (event) => this._end(event));
  }

  _begin(event, itemAt) {
    if (!event.isPrimary || event.button === 1) return;
    const item = itemAt(event);
    if (item?.role !== "platform") return;
    const { position, quaternion } = this.solver.solution();
    if (!position) return;
    this.drawing.controls.enabled = false;
    this.drawing.canvas.setPointerCapture(event.pointerId);
    this.held = { x: event.clientX, y: event.clientY, position: [...position], quaternion: [...quaternion], turns: event.shiftKey || event.button === 2 };
    this.drawing.canvas.classList.add("dragging");
  }

  _move(event) {
    if (!this.held) return;
    const dx = event.clientX - this.held.x, dy = event.clientY - this.held.y;
    this.wanted = this.held.turns ? this._turned(dx, dy) : this._moved(dx, dy);
  }

  /** Go where the pointer was last, once a frame. */
  step() {
    if (!this.wanted) return;
    const [position, quaternion] = this.wanted;
    this.wanted = null;
    this.onMove(this.solver.dragTo(position, quaternion));
  }

  _moved(dx, dy) {
    const [right, up] = this.drawing.axes, scale = this.drawing.lengthOfPixel;
    const position = this.held.position.map((v, k) => v + scale * (dx * right[k] - dy * up[k]));
    // a platform with fewer freedoms turns as it must
    return [position, this.solver.names.length >= 6 ? this.held.quaternion : null];
  }

  _turned(dx, dy) {
    const [right, up] = this.drawing.axes.map((way) => new THREE.Vector3(...way)), rate = 0.008;
    const turn = new THREE.Quaternion().setFromAxisAngle(up, rate * dx);
    turn.multiply(new THREE.Quaternion().setFromAxisAngle(right, rate * dy));
    const [w, x, y, z] = this.held.quaternion;
    turn.multiply(new THREE.Quaternion(x, y, z, w));
    return [this.held.position, [turn.w, turn.x, turn.y, turn.z]];
  }

  _end(event) {
    if (!this.held) return;
    this.step();
    this.held = null;
    this.drawing.controls.enabled = true;
    this.drawing.canvas.classList.remove("dragging");
    event.preventDefault();
  }
}
