// All complex solutions: found once for complex values by monodromy, then moved to the present values along paths.
//
// At the complex values p0 solutions are known from seeds on, which are all where the unknown is one body on rods, else some: moved
// around loops p0 -> pa -> pb -> p0 they become others, until the number that symkin counts is reached. From p0, which is generic,
// paths to any real values meet no singularity on the way; their ends that are real are the modes.
import { complexLeastSquares } from "solver-algebra";

const LONGEST = 0.35, SHORTEST = 1e-10; // steps of a path's parameter
const MOST_STEPS = 1000; // of a path: where rows are more than the unknowns and the values do not agree, steps stay short
const FAR = 1e6; // of a solution at infinity, in units of the size
const SAME = 1e-6; // between two writings of one solution
const REAL = 1e-6; // imaginary part of a real end before Newton's method makes it real
const INFINITE = "infinite"; // what a path ends with that goes to infinity
const WIDE = 3; // spread of loops' corners, of the size and radians: narrow loops go around no branch point
const QUIET = 8; // loops without a new solution after which the search ends
const MOST_SEARCHED = 150000; // steps of all paths of a search that symkin's count does not end: half a minute

export class Roots {
  constructor(solver) {
    Object.assign(this, { solver, model: solver.model, functions: solver.functions });
    const { rows, width } = this.model;
    this.rowsAt = new Float64Array(2 * rows);
    this.gradients = new Float64Array(2 * rows * width);
    this.starts = [];
    this.unresolved = 0;
    this.quiet = 0;
    this.random = generator(20170614);
    this.alone = !this.model.complex || !this.model.follows || !solver.places.length || !solver.unknown.length;
    this.done = this.alone;
    this.steps = 0; // of all paths so far
    this.tooMany = false;
  }

  /** Whether the modes at the last values asked for are all: as many complex solutions as symkin counts, every path with an end of its own. */
  get complete() {
    const { complexCount, follows } = this.model;
    if (!this.done || !follows || complexCount === null) return false;
    if (this.alone) return !this.solver.places.length || !this.solver.unknown.length;
    return this.starts.length >= complexCount && !this.unresolved;
  }

  get sentence() {
    const { complexCount, follows, mostFollowed } = this.model, found = this.starts.length;
    if (!this.done) return "Finding all solutions.";
    if (!follows || this.tooMany) {
      const counted = complexCount !== null, many = counted ? complexCount : `More than ${mostFollowed}`;
      return `${many} complex solutions are too many to follow here: away from the start the mode shown alone is followed; symkin modes finds ${counted ? "all" : "others"}.`;
    }
    if (this.alone) return "";
    if (!found) return "No solution could be followed to other values, which must perhaps agree with each other: the mode shown alone is followed; symkin modes finds all.";
    const open = this.unresolved ? ` ${this.unresolved} of ${found} paths are unresolved here: modes may be missing.` : "";
    if (complexCount !== null && found < complexCount) return `${found} of the ${complexCount} complex solutions that symkin counts are followed here.${open}`;
    const ended = complexCount === null && this.steps > MOST_SEARCHED ? "; the search for more took too long" : "";
    return `${found} complex ${found === 1 ? "solution is" : "solutions are"} followed${ended}.${open}`;
  }

  /** Search for all real solutions at the known values of x, itself among them, a path at a time; solutions at p0 are sought once. */
  *search(x) {
    if (!this.done && !this.p0) this._begin();
    while (!this.done) {
      this.seeds.length ? this._seed(this.seeds.shift()) : this._loop();
      yield;
    }
    const found = this.alone ? this._seedsAt(x) : yield* this._ends(x);
    if (!found.some((other) => this.same(other, x))) found.unshift(Float64Array.from(x));
    return found;
  }

  indexOf(list, x) {
    return list.findIndex((other) => this.same(other, x));
  }

  same(a, b, pairs = 1) {
    return this._apart(a, b, pairs) < (pairs === 1 ? 1e-7 : SAME);
  }

  // --- search ----------------------------------------------------------------------------------------------------------

  _begin() {
    this.p0 = this._randomValues();
    const { start, complexHere, modesHere, seeds } = this.model;
    this.seeds = [...complexHere.map((pairs) => Float64Array.from(pairs)), ...[start, ...modesHere, ...seeds].map(complexOf)];
  }

  /** Move a solution at values of its own to p0. */
  _seed(from) {
    const p = this.solver.places.flatMap((k) => [from[2 * k], 0]), end = this._path(from, p, this.p0);
    if (end && end !== INFINITE && !this.starts.some((other) => this.same(other, end, 2))) this.starts.push(end);
    this._ended();
  }

  /** Complex values about the start, `spread` wide in units of the size and radians. */
  _randomValues(spread = 1) {
    const { places } = this.solver, { start, columns } = this.model;
    return places.flatMap((k) => [start[k] + spread * columns[k] * (this.random() - 0.5), spread * columns[k] * (this.random() - 0.5)]);
  }

  /** Move the solutions, one after another, around a loop; the loop ends when all have been moved. */
  _loop() {
    if (!this.loop || this.loop.next >= this.loop.count) {
      const [pa, pb] = [0, 1].map(() => this._randomValues(WIDE * 8 ** (this.random() - 0.5)));
      this.loop = { corners: [this.p0, pa, pb, this.p0], next: 0, count: this.starts.length, news: 0 };
      if (!this.loop.count) this.done = true;
    }
    const { corners } = this.loop;
    let x = this.starts[this.loop.next++];
    for (let k = 0; k < 3 && x && x !== INFINITE; k++) x = this._path(x, corners[k], corners[k + 1]);
    if (x && x !== INFINITE && !this.starts.some((other) => this.same(other, x, 2))) {
      this.starts.push(x);
      this.loop.news++;
    }
    if (this.loop.next >= this.loop.count) this.quiet = this.loop.news ? 0 : this.quiet + 1;
    this._ended();
  }

  _ended() {
    const { complexCount, mostFollowed } = this.model, count = this.starts.length;
    this.tooMany = count > mostFollowed;
    this.alone ||= this.tooMany;
    this.done = this.tooMany || (complexCount !== null && count >= complexCount) || this.quiet >= QUIET || this.steps > MOST_SEARCHED;
  }

  // --- ends ------------------------------------------------------------------------------------------------------------

  /** Where there is no search: the seeds where the values are those of the start, else x alone. */
  _seedsAt(x) {
    return this._atStart(x) ? this.startModes() : [];
  }

  _atStart(x) {
    return this.solver.places.every((k) => Math.abs(x[k] - this.model.start[k]) < 1e-12 * this.model.columns[k]);
  }

  /** The modes at the values of the start. */
  startModes() {
    return this.model.modesHere.map((seed) => {
      const mode = Float64Array.from(seed);
      for (const k of this.solver.places) mode[k] = this.model.start[k]; // with its whole turns
      return mode;
    });
  }

  /** Real ends of all paths to the values of x; `unresolved` counts paths that neither end nor go to infinity, or share an end. */
  *_ends(x) {
    if (this._atStart(x) && this.model.complexCount !== null) {
      this.unresolved = 0; // symkin has found the modes of the start
      return this.startModes();
    }
    const { places } = this.solver, target = places.flatMap((k) => [x[k], 0]);
    let ends = yield* this._all(() => true, (start) => this._path(start, this.p0, target));
    for (const longest of [0.05, 0.01]) {
      const open = this._open(ends);
      if (!open.some(Boolean)) break;
      ends = yield* this._all((k) => open[k], (start) => this._path(start, this.p0, target, longest), ends);
    }
    if (this._open(ends).some(Boolean)) ends = this._fewerOpen(ends, yield* this._detour(target));
    this.unresolved = this._open(ends).filter(Boolean).length;
    const found = [];
    for (const end of ends) {
      const real = end && end !== INFINITE && this._real(end, x);
      if (real && !found.some((other) => this.same(other, real))) found.push(real);
    }
    return found;
  }

  /** `end` of the starts that are chosen by number, a start at a time; of the others what it was. */
  *_all(chosen, end, before = []) {
    const ends = [...before];
    for (const [k, start] of this.starts.entries()) {
      if (!chosen(k)) continue;
      ends[k] = end(start);
      yield;
    }
    return ends;
  }

  /** Which paths are in doubt: those without an end, and those with the end of another. */
  _open(ends) {
    const finite = (end) => end && end !== INFINITE;
    return ends.map((end, k) => !end || (finite(end) && ends.some((other, j) => j !== k && finite(other) && this.same(other, end, 2))));
  }

  /** Ends of paths over other complex values. */
  *_detour(target) {
    const corner = this._randomValues();
    return yield* this._all(() => true, (start) => {
      const half = this._path(start, this.p0, corner);
      return half && half !== INFINITE ? this._path(half, corner, target) : half;
    });
  }

  _fewerOpen(first, second) {
    const count = (ends) => this._open(ends).filter(Boolean).length;
    return count(second) < count(first) ? second : first;
  }

  /** The real solution at a complex one's place, null where there is none. */
  _real(end, x) {
    const { columns, width } = this.model, real = new Float64Array(width);
    for (let k = 0; k < width; k++) {
      if (Math.abs(end[2 * k + 1]) > REAL * columns[k] * (1 + Math.abs(end[2 * k] / columns[k]))) return null;
      real[k] = end[2 * k];
    }
    this.solver.places.forEach((k) => (real[k] = x[k]));
    const near = Float64Array.from(real);
    return this.solver.correct(real) && this._apart(near, real, 1) < 1e-3 ? this._standard(real) : null;
  }

  /** Angles without whole turns, quaternions with w >= 0, rods of positive length, of the unknowns. */
  _standard(x) {
    for (const c of this.model.coordinates.filter((one) => !one.known)) {
      if (c.kind === "angle") x[c.place] -= 2 * Math.PI * Math.round(x[c.place] / (2 * Math.PI));
      else if (c.kind === "quaternion" && x[c.place] < 0) for (let k = 0; k < 4; k++) x[c.place + k] *= -1;
      else if (c.least !== null && x[c.place] < c.least) x[c.place] = 2 * c.least - x[c.place];
    }
    return x;
  }

  /** Distance of two solutions, real (pairs = 1) or complex (2): the same up to turns, signs of quaternions and of rods' lengths. */
  _apart(a, b, pairs) {
    let most = 0;
    const { columns } = this.model;
    const gap = (k, shift = 0, sign = 1) =>
      pairs === 1 ? Math.abs(a[k] - sign * b[k] - shift) : Math.hypot(a[2 * k] - sign * b[2 * k] - shift, a[2 * k + 1] - sign * b[2 * k + 1]);
    for (const c of this.model.coordinates.filter((one) => !one.known)) {
      const k = c.place, step = pairs * k;
      let d;
      if (c.kind === "quaternion") d = Math.min(...[1, -1].map((sign) => Math.max(...[0, 1, 2, 3].map((i) => gap(k + i, 0, sign)))));
      else if (c.kind === "angle") d = gap(k, 2 * Math.PI * Math.round((a[step] - b[step]) / (2 * Math.PI)));
      else d = c.least === null ? gap(k) : Math.min(gap(k), gap(k, 2 * c.least, -1));
      most = Math.max(most, d / columns[k] / (1 + Math.abs(a[step]) / columns[k]));
    }
    return most;
  }

  // --- paths -----------------------------------------------------------------------------------------------------------

  /** The end at known values q of the path from solution x at p; INFINITE, or null where the steps become too short. */
  _path(x, p, q, longest = LONGEST) {
    const way = q.map((v, k) => v - p[k]);
    let t = 0, step = Math.min(0.1, longest), here = Float64Array.from(x);
    for (let steps = 0; t < 1; steps++) {
      if (steps > MOST_STEPS) return null;
      this.steps++;
      step = Math.min(step, 1 - t);
      const next = this._advance(here, p, way, t, step);
      if (!next) {
        step *= 0.5;
        if (step < SHORTEST) return null;
        continue;
      }
      here = next.x;
      t = step === 1 - t ? 1 : t + step;
      if (next.error < 1e-5) step = Math.min(2 * step, longest);
      else if (next.error > 1e-3) step *= 0.5;
      if (this._far(here)) return INFINITE;
    }
    return this._newton(here, 1e-13, 6) ? here : null;
  }

  /** Whether a solution has gone to infinity: a length, or the imaginary part of an angle, whose sine grows with it. */
  _far(x) {
    const { columns, coordinates } = this.model;
    return coordinates.some((c) => {
      const k = 2 * c.place;
      if (c.known || c.kind === "quaternion") return !c.known && Math.hypot(x[k], x[k + 1]) > FAR;
      return c.kind === "length" ? Math.hypot(x[k], x[k + 1]) > FAR * columns[c.place] : Math.abs(x[k + 1]) > 25;
    });
  }

  /** A step of Runge and Kutta's fourth order, then Newton's method; its first correction is the step's error. */
  _advance(x, p, way, t, step) {
    const slopes = [], stages = [[0, 0], [0.5, 0], [0.5, 1], [1, 2]];
    for (const [share, before] of stages) {
      const at = share ? this._moved(x, slopes[before], share * step) : Float64Array.from(x);
      this._setKnown(at, p, way, t + share * step);
      const slope = this._tangent(at, way);
      if (!slope) return null;
      slopes.push(slope);
    }
    const mean = slopes[0].map((v, k) => (v + 2 * slopes[1][k] + 2 * slopes[2][k] + slopes[3][k]) / 6);
    const next = this._moved(x, mean, step);
    this._setKnown(next, p, way, step === 1 - t ? 1 : t + step);
    const error = this._newton(next, 1e-9, 3);
    return error && error < 2e-2 ? { x: next, error } : null;
  }

  _moved(x, slope, step) {
    const next = Float64Array.from(x), { columns } = this.model;
    this.solver.unknown.forEach((k, i) => {
      next[2 * k] += step * columns[k] * slope[2 * i];
      next[2 * k + 1] += step * columns[k] * slope[2 * i + 1];
    });
    return next;
  }

  _setKnown(x, p, way, t) {
    this.solver.places.forEach((k, i) => {
      x[2 * k] = p[2 * i] + t * way[2 * i];
      x[2 * k + 1] = p[2 * i + 1] + t * way[2 * i + 1];
    });
  }

  _tangent(x, way) {
    const a = this._linearise(x), { rows, width, columns } = this.model, b = new Float64Array(2 * rows);
    this.solver.places.forEach((k, i) => {
      const re = way[2 * i] / columns[k], im = way[2 * i + 1] / columns[k];
      for (let r = 0; r < rows; r++) {
        const gr = this.gradients[2 * (r * width + k)], gi = this.gradients[2 * (r * width + k) + 1];
        b[2 * r] -= gr * re - gi * im;
        b[2 * r + 1] -= gr * im + gi * re;
      }
    });
    return complexLeastSquares(a, b, rows, this.solver.unknown.length);
  }

  /** Newton's method in place until a step is below `close`; the first step's length (at least 1e-300), 0 where it fails. Lengths of
   * steps are shares of the solution's own where that is large. */
  _newton(x, close, most) {
    const { rows, columns } = this.model, { unknown } = this.solver;
    let first = 0, last = Infinity;
    for (let k = 0; k < most; k++) {
      const a = this._linearise(x);
      const step = complexLeastSquares(a, this.rowsAt.map((v) => -v), rows, unknown.length);
      if (!step) return 0;
      let length = 0;
      for (const v of step) length += v * v;
      length = Math.sqrt(length) / this._magnitude(x);
      if (!(length < 10)) return 0;
      unknown.forEach((place, i) => {
        x[2 * place] += columns[place] * step[2 * i];
        x[2 * place + 1] += columns[place] * step[2 * i + 1];
      });
      if (k === 0) first = Math.max(length, 1e-300);
      if (length < close || (length < 1e-8 && length > 0.3 * last)) return first;
      last = length;
    }
    return last < 1e-7 ? first : 0;
  }

  /** The largest unknown, in units of its column, at least 1. */
  _magnitude(x) {
    const { columns } = this.model;
    return this.solver.unknown.reduce((most, k) => Math.max(most, Math.hypot(x[2 * k], x[2 * k + 1]) / columns[k]), 1);
  }

  _linearise(x) {
    const { rows, width } = this.model, { unknown } = this.solver, count = unknown.length;
    this.functions.complexSystem(x, this.rowsAt, this.gradients);
    const a = new Float64Array(2 * rows * count);
    for (let r = 0; r < rows; r++)
      for (let i = 0; i < count; i++) {
        const from = 2 * (r * width + unknown[i]), to = 2 * (r * count + i);
        a[to] = this.gradients[from];
        a[to + 1] = this.gradients[from + 1];
      }
    return a;
  }
}

function complexOf(x) {
  const pairs = new Float64Array(2 * x.length);
  Array.from(x).forEach((v, k) => (pairs[2 * k] = v));
  return pairs;
}

/** Uniform numbers in [0, 1) from a seed (Mulberry32). */
function generator(seed) {
  let state = seed;
  return () => {
    state = (state + 0x6d2b79f5) | 0;
    let v = Math.imul(state ^ (state >>> 15), 1 | state);
    v = (v + Math.imul(v ^ (v >>> 7), 61 | v)) ^ v;
    return ((v ^ (v >>> 14)) >>> 0) / 4294967296;
  };
}
