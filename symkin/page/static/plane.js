// A plane of two coordinates with singular curves and the map of a sweep: where the mechanism is, and a place to point at where it shall go.

export class PlaneMap {
  /** `plane` as `plane.py` paints it; `go(u, v)` moves there; `now()` tells where it is, `off()` the names of what it holds that have other
   * values now. */
  constructor(place, plane, { go, now, off }) {
    Object.assign(this, { plane, go, now, off });
    place.hidden = false;
    place.innerHTML = plane.html;
    [this.elsewhere, this.picture, this.mark] = ["[aria-live]", "svg", ".picture i"].map((name) => place.querySelector(name));
    this.picture.addEventListener("pointerdown", (event) => {
      this.picture.setPointerCapture(event.pointerId);
      this._point(event);
    });
    this.picture.addEventListener("pointermove", (event) => event.buttons && this._point(event));
    this.picture.addEventListener("keydown", (event) => this._key(event));
  }

  /** Go to the place pointed at, once a frame. */
  step() {
    if (!this.wanted) return;
    const wanted = this.wanted;
    this.wanted = null;
    this.go(...wanted);
  }

  _point(event) {
    const box = this.picture.getBoundingClientRect();
    const shares = [(event.clientX - box.left) / box.width, (box.bottom - event.clientY) / box.height];
    this.wanted = this.plane.ranges.map(([low, high], k) => low + Math.min(1, Math.max(0, shares[k])) * (high - low));
  }

  /** Arrow keys move by a fiftieth of the sides. */
  _key(event) {
    const way = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!way) return;
    event.preventDefault();
    const now = this.now();
    this.wanted = this.plane.ranges.map(([low, high], k) => Math.min(high, Math.max(low, now[k] + (way[k] * (high - low)) / 50)));
  }

  /** Mark where the mechanism is; a picture that was made with other values of what it holds is one of elsewhere. */
  draw() {
    const off = this.off(), now = this.now(), { ranges, what } = this.plane;
    this.elsewhere.textContent = off.length ? `The ${what} is for other values of ${off.join(", ")}.` : "";
    this.picture.classList.toggle("elsewhere", off.length > 0);
    const [left, bottom] = ranges.map(([low, high], k) => `${(100 * (now[k] - low)) / (high - low)}%`);
    Object.assign(this.mark.style, { left, bottom });
  }
}
