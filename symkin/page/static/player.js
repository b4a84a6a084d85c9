// A path: rows of given values, played at a speed, with its place on a slider.

const SECONDS = 8; // of a whole path at speed 1 where the file has no times

export class Player {
  /** `path` {names, rows, times or null, title}; `go(values)` moves there and tells what came of it; `onStop(stop, share)`: a stop, and
   * the share of the path at which it is. */
  constructor(element, path, { go, onStop }) {
    Object.assign(this, { path, go, onStop });
    this.times = path.times ?? path.rows.map((_, k) => (SECONDS * k) / Math.max(1, path.rows.length - 1));
    this.time = this.times[0];
    this.running = false;
    element.hidden = false;
    element.querySelector(".path-title").textContent = `Path ${path.title}`;
    this.button = element.querySelector(".play");
    this.place = element.querySelector(".place");
    this.place.min = this.times[0];
    this.place.max = this.times[this.times.length - 1];
    this.place.value = this.time;
    this.speed = element.querySelector("select");
    this.button.addEventListener("click", () => this.play(!this.running));
    this.place.addEventListener("input", () => this.seek(this.place.valueAsNumber));
  }

  play(running) {
    if (running && this.time >= this.times[this.times.length - 1]) this.seek(this.times[0]);
    this.running = running;
    this.last = performance.now();
    this.button.textContent = running ? "Pause" : "Play";
  }

  /** Stand at the beginning of the path. */
  rewind() {
    this.play(false);
    this.place.value = this.time = this.times[0];
  }

  /** One frame further. */
  step(now) {
    if (!this.running) return;
    const time = this.time + ((now - this.last) / 1000) * Number(this.speed.value);
    this.last = now;
    const end = this.times[this.times.length - 1];
    if (!this.seek(Math.min(time, end)) || time >= end) this.play(false);
  }

  /** Go to a time, row by row, so that the path is kept; whether it was reached. */
  seek(time) {
    const ahead = time >= this.time ? 1 : -1, between = (t) => (ahead > 0 ? t > this.time && t < time : t < this.time && t > time);
    const rows = this.times.map((t, k) => [t, k]).filter(([t]) => between(t));
    if (ahead < 0) rows.reverse();
    for (const [t, k] of rows) {
      if (!this._go(t, this.path.rows[k])) return false;
    }
    return this._go(time, this._row(time));
  }

  _go(time, row) {
    const result = this.go(Object.fromEntries(this.path.names.map((name, k) => [name, row[k]])));
    if (!result.reached) {
      const [first, last] = [this.times[0], this.times[this.times.length - 1]];
      this.onStop(result.stop, (this.time + result.share * (time - this.time) - first) / (last - first));
      return false;
    }
    this.time = time;
    this.place.value = time;
    return true;
  }

  _row(time) {
    const { times } = this, { rows } = this.path;
    let k = times.findIndex((t) => t >= time);
    if (k < 0) k = times.length - 1;
    if (k === 0) return rows[0];
    const share = (time - times[k - 1]) / (times[k] - times[k - 1] || 1);
    return rows[k].map((value, i) => rows[k - 1][i] + share * (value - rows[k - 1][i]));
  }
}
