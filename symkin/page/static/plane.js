// A plane of two coordinates with singular curves: where the mechanism is, and a place to point at where it shall go.
const COLOURS = { "type 1": "#d55e00", "type 2": "#0072b2", passive: "#009e73" };
const SIDE = 14; // pixels around the plane

export class PlaneMap {
  /** `plane` {names, units, ranges, held, curves: [{kind, points}]}; `go(u, v)` moves there; `now()` tells where it is. */
  constructor(element, plane, { go, now, ink }) {
    Object.assign(this, { plane, go, now, ink });
    element.hidden = false;
    const kinds = [...new Set(plane.curves.map((curve) => curve.kind))];
    const title = Object.assign(document.createElement("p"), { className: "path-title" });
    title.textContent = `Singular curves${kinds.length ? ` (${kinds.join(", ")})` : ": none met"}; ${plane.held}`;
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `Plane of ${plane.names.join(" and ")} with singular curves; point at a place to go there, or use the sliders`);
    element.append(title, this.canvas);
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this._point(event);
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons && this._point(event));
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  /** Go to the place pointed at, once a frame. */
  step() {
    if (!this.wanted) return;
    const wanted = this.wanted;
    this.wanted = null;
    this.go(...wanted);
  }

  _point(event) {
    const box = this.canvas.getBoundingClientRect(), [[u0, u1], [v0, v1]] = this.plane.ranges;
    const share = (value) => Math.min(1, Math.max(0, value));
    const x = share((event.clientX - box.left - SIDE) / (box.width - 2 * SIDE)), y = share((box.bottom - SIDE - event.clientY) / (box.height - 2 * SIDE));
    this.wanted = [u0 + x * (u1 - u0), v0 + y * (v1 - v0)];
  }

  draw() {
    const { canvas, plane } = this, ratio = Math.min(window.devicePixelRatio || 1, 2), width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = width * ratio;
    canvas.height = height * ratio;
    const pen = canvas.getContext("2d"), [[u0, u1], [v0, v1]] = plane.ranges;
    pen.scale(ratio, ratio);
    const at = ([u, v]) => [SIDE + ((u - u0) / (u1 - u0)) * (width - 2 * SIDE), height - SIDE - ((v - v0) / (v1 - v0)) * (height - 2 * SIDE)];
    pen.strokeStyle = this.ink("axis");
    pen.strokeRect(SIDE, SIDE, width - 2 * SIDE, height - 2 * SIDE);
    pen.save();
    pen.beginPath();
    pen.rect(SIDE, SIDE, width - 2 * SIDE, height - 2 * SIDE);
    pen.clip();
    for (const { kind, points } of plane.curves) this._curve(pen, points.map(at), COLOURS[kind] ?? this.ink("loop"));
    pen.restore();
    this._words(pen, width, height);
    const [x, y] = at(this.now());
    pen.fillStyle = this.ink("accent");
    pen.beginPath();
    pen.arc(x, y, 5, 0, 2 * Math.PI);
    pen.fill();
  }

  _curve(pen, places, colour) {
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineWidth = 1.8;
    pen.beginPath();
    if (places.length === 1) pen.arc(...places[0], 3, 0, 2 * Math.PI);
    places.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.stroke();
  }

  _words(pen, width, height) {
    const [u, v] = this.plane.names, [[u0, u1], [v0, v1]] = this.plane.ranges, round = (value) => Number(value.toPrecision(4));
    pen.fillStyle = this.ink("quiet");
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "right";
    pen.fillText(`${u} ${round(u0)} to ${round(u1)} ${this.plane.units[0]}`, width - SIDE, height - 3);
    pen.textAlign = "left";
    pen.fillText(`${v} ${round(v0)} to ${round(v1)} ${this.plane.units[1]}`, SIDE, 10);
  }
}
