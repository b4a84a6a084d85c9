// The paths of the platform's origin and of named points while the mechanism moves.
const MOST = 5000; // places kept of each point
const COLOURS = ["accent", "loop", "frame y", "frame z"];

export class Trace {
  /** `points` are items of the scene with `link` and `point`. */
  constructor(drawing, points) {
    Object.assign(this, { drawing, points });
    this.on = false;
    this.clear();
  }

  set(on) {
    this.on = on;
    this.clear();
  }

  clear() {
    this.paths = this.points.map(() => []);
    this.drawing.clearExtras("trace");
  }

  /** Keep where the points are now. */
  add() {
    if (!this.on) return;
    const near = 1e-4 * this.drawing.scene.size;
    let moved = false;
    this.points.forEach((item, k) => {
      const place = this.drawing.items.at(item), path = this.paths[k];
      if (path.length && path[path.length - 1].distanceTo(place) < near) return;
      path.push(place);
      if (path.length > MOST) path.shift();
      moved = true;
    });
    if (!moved) return;
    this.drawing.clearExtras("trace");
    this.paths.forEach((path, k) => this.drawing.showTrace(path, COLOURS[k % COLOURS.length]));
  }
}
