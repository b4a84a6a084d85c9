// A plane of two coordinates with singular curves and the map of a sweep: where the mechanism is, and a place to point at where it shall go.
import { element } from "symkin/inputs";

const SIDE = 14; // pixels around the plane
const NO_MODE = { light: "#dfe3e8", dark: "#333a44" };
const MOST_APART = Math.log(1.5); // of the sides' lengths

/** Entries [colour, text] as what is appended to a title: swatches with their texts, which stay together; nothing of none. */
function keyOf(entries, kind = "") {
  const list = element("span", { className: "legend" });
  for (const [colour, text] of entries) {
    const item = element("span"), swatch = element("i", { className: colour ? kind : "no-mode" });
    if (colour) swatch.style.background = colour;
    item.append(swatch, text);
    list.append(item, " ");
  }
  return entries.length ? [" ", list] : [];
}

export class PlaneMap {
  /** `plane` as `plane.py` paints it; `go(u, v)` moves there; `now()` tells where it is, `off()` the names of what it holds that have other
   * values now. */
  constructor(place, plane, { go, now, off, ink }) {
    Object.assign(this, { plane, go, now, off, ink });
    place.hidden = false;
    const title = element("p", { className: "path-title", textContent: plane.title });
    title.append(...keyOf(plane.kinds, "curve"));
    if (plane.map) title.append(plane.map.every, ...keyOf(plane.map.legend));
    this.canvas = element("canvas", { tabIndex: 0 });
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", plane.label);
    this.elsewhere = element("div", { className: "path-title" });
    this.elsewhere.setAttribute("aria-live", "polite");
    place.append(title, this.elsewhere, this.canvas);
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this._point(event);
    });
    this.canvas.addEventListener("pointermove", (event) => event.buttons && this._point(event));
    this.canvas.addEventListener("keydown", (event) => this._key(event));
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  /** The map's cells or dots, drawn once for each size and theme. */
  _map(at, width, height, ratio) {
    const { edges, points, fills, shades } = this.plane.map, none = NO_MODE[document.documentElement.dataset.theme === "dark" ? "dark" : "light"];
    const key = [width, height, ratio, none].join();
    if (this.drawn?.key === key) return this.drawn.canvas;
    const canvas = element("canvas", { width: width * ratio, height: height * ratio }), pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    fills.forEach((shade, k) => {
      if (points && shade === null) return;
      pen.fillStyle = shade === null ? "#fff" : (shades[shade] ?? none);
      if (points) {
        const [x, y] = at(points[k]);
        return pen.fillRect(x - 1.5, y - 1.5, 3, 3);
      }
      const n = edges[1].length - 1, i = Math.floor(k / n), j = k % n;
      const whole = (place) => at(place).map((v) => Math.round(v * ratio) / ratio); // no seams between cells
      const [x0, y1] = whole([edges[0][i], edges[1][j]]), [x1, y0] = whole([edges[0][i + 1], edges[1][j + 1]]);
      pen.fillRect(x0, y0, x1 - x0, y1 - y0);
    });
    this.drawn = { key, canvas };
    return canvas;
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

  /** Arrow keys move by a fiftieth of the sides. */
  _key(event) {
    const way = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!way) return;
    event.preventDefault();
    const now = this.now();
    this.wanted = this.plane.ranges.map(([low, high], k) => Math.min(high, Math.max(low, now[k] + (way[k] * (high - low)) / 50)));
  }

  draw() {
    const { canvas, plane } = this, ratio = Math.min(window.devicePixelRatio || 1, 2), width = canvas.clientWidth;
    const [across, up] = plane.ranges.map(([low, high]) => high - low);
    // one scale for both sides, where they have one unit and are about as long
    if (plane.units[0] === plane.units[1] && Math.abs(Math.log(up / across)) < MOST_APART) canvas.style.height = `${((width - 2 * SIDE) * up) / across + 2 * SIDE}px`;
    const height = canvas.clientHeight;
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
    // made with other values of what it holds, it is a picture of elsewhere
    const off = this.off();
    this.elsewhere.textContent = off.length ? `The ${plane.map ? "map" : "plane"} is for other values of ${off.join(", ")}.` : "";
    pen.globalAlpha = off.length ? 0.25 : 1;
    if (plane.map) pen.drawImage(this._map(at, width, height, ratio), 0, 0, width, height);
    for (const { colour, points } of plane.curves) this._curve(pen, points.map(at), colour);
    pen.restore();
    this._words(pen, width, height);
    const [x, y] = at(this.now());
    pen.fillStyle = this.ink("accent");
    pen.strokeStyle = "#fff";
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.arc(x, y, 5, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
  }

  _curve(pen, places, colour) {
    pen.beginPath();
    if (places.length === 1) pen.arc(...places[0], 3, 0, 2 * Math.PI);
    places.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    // a pale edge, so that a curve is seen on every colour of the map
    for (const [ink, wide] of this.plane.map ? [["#fff", 4.4], [colour, 2.2]] : [[colour, 1.8]]) {
      pen.strokeStyle = ink;
      pen.lineWidth = wide;
      pen.stroke();
    }
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
