// All solutions at given values: the steps of symkin's plan one after another, each for every choice of those before it.
//
// A step's unknowns follow from formulas with signs; where these lose digits, and where there are none, they are the ends of paths
// from complex solutions that symkin has found: from generic known values, paths to any real ones meet no singularity on the way.
import { apart, standard } from "solver-coordinates";
import { System } from "solver-system";

const LONGEST = [0.35, 0.05, 0.01]; // steps of a path's parameter, at first and where paths are in doubt
const SHORTEST = 1e-10;
const MOST_STEPS = 1000; // of a path: where rows are more than the unknowns and the values do not agree, steps stay short
const FAR = 1e6; // of a solution at infinity, in units of the size
const FAR_ANGLE = 25; // its imaginary part, whose sine grows with it
const SAME = [1e-7, 1e-6]; // between two writings of one real solution, of one complex solution
const REAL = 1e-6; // imaginary part of a real end before Newton's method makes it real
const INFINITE = "infinite"; // what a path ends with that goes to infinity
const isFinite = (end) => end && end !== INFINITE;

export class Roots {
  constructor(solver) {
    Object.assign(this, { solver, model: solver.model });
    this.coordinates = this.model.coordinates.filter((c) => !c.known);
    this.steps = this.model.follows ? this.model.steps.map((step) => new Step(solver, step)) : [];
    this.unresolved = 0;
  }

  /** Whether the modes at the last values asked for are all: every step accounts for its solutions. */
  get complete() {
    const { complexCount, follows } = this.model;
    return follows && complexCount !== null && !this.unresolved;
  }

  get sentence() {
    const open = this.unresolved;
    return this.model.sentence + (open ? ` ${open} ${open === 1 ? "path is" : "paths are"} unresolved here: modes may be missing.` : "");
  }

  /** Search for all real solutions at the known values of x, itself among them, a path at a time. */
  *search(x) {
    this.unresolved = 0;
    const found = this._atStart(x) ? this.startModes() : [];
    if (!found.length || this.model.complexCount === null) for (const end of yield* this._ends(x)) this._add(found, end);
    if (!found.some((other) => this.same(other, x))) found.unshift(Float64Array.from(x));
    return found;
  }

  indexOf(list, x) {
    return list.findIndex((other) => this.same(other, x));
  }

  same(a, b) {
    return apart(this.model, this.coordinates, a, b, 1) < SAME[0];
  }

  /** The modes at the values of the start, as symkin has found them. */
  startModes() {
    return this.model.modesHere.map((seed) => {
      const mode = Float64Array.from(seed);
      for (const k of this.solver.places) mode[k] = this.model.start[k]; // with its whole turns
      return mode;
    });
  }

  _atStart(x) {
    return this.solver.places.every((k) => Math.abs(x[k] - this.model.start[k]) < 1e-12 * this.model.columns[k]);
  }

  /** Configurations in which every step has one of its solutions. */
  *_ends(x) {
    let list = this.steps.length ? [Float64Array.from(x)] : [];
    for (const step of this.steps) {
      const next = [];
      for (const here of list) for (const root of yield* step.roots(here)) next.push(root);
      list = next;
    }
    this.unresolved = this.steps.reduce((sum, step) => sum + step.unresolved, 0);
    return list;
  }

  /** Add a configuration that closes on all rows. */
  _add(found, end) {
    const near = Float64Array.from(end);
    if (!this.solver.correct(end) || apart(this.model, this.coordinates, near, end, 1) > 1e-3) return;
    standard(this.coordinates, end);
    if (!found.some((other) => this.same(other, end))) found.push(end);
  }
}

/** One step: `places` of its known values and unknowns, `signs` of its formulas' branches, `starts` as pairs at these places. */
class Step {
  constructor({ model, functions }, { number, known, unknown, rows, signs, margins, starts }) {
    Object.assign(this, { model, known, unknown, signs, margins });
    this.coordinates = model.coordinates.filter((c) => unknown.includes(c.place));
    this.starts = starts.map((pairs) => {
      const start = new Float64Array(2 * model.width);
      [...known, ...unknown].forEach((place, k) => start.set(pairs.slice(2 * k, 2 * k + 2), 2 * place));
      return start;
    });
    const pairs = (places) => places.flatMap((k) => [2 * k, 2 * k + 1]), columns = model.columns.flatMap((v) => [v, v]);
    // paths from generic values keep full rank
    this.system = new System(functions[`step${number}`], { rows, columns, known: pairs(known), unknown: pairs(unknown), pivoted: false });
    this.branches = functions[`branches${number}`];
    this.unresolved = 0;
  }

  /** Copies of x with each solution of the step; those of the last known values are kept. */
  *roots(x) {
    const key = this.known.map((place) => x[place]).join();
    if (this.key !== key) this.found = this._byFormulas(x) ?? (yield* this._alongPaths(x));
    this.key = key;
    return this.found.map((root) => {
      const whole = Float64Array.from(x);
      for (const place of this.unknown) whole[place] = root[place];
      return whole;
    });
  }

  /** The real branches of the formulas; null where there are none, or where they lose digits and paths do not. */
  _byFormulas(x) {
    if (!this.signs) return null;
    const found = [];
    this.unresolved = 0;
    for (const signs of this.signs) {
      const values = this.unknown.map(() => 0), discriminants = signs.map(() => 0), margins = Array(this.margins).fill(0);
      this.branches([...x, ...signs], values, discriminants, margins);
      if (!values.every(Number.isFinite) || margins.some((v) => !(v > 0))) {
        if (this.starts.length) return null;
        this.unresolved = 1;
      }
      if (!values.every(Number.isFinite) || discriminants.some((v) => v < 0)) continue;
      const root = Float64Array.from(x);
      this.unknown.forEach((place, k) => (root[place] = values[k]));
      found.push(root);
    }
    return found;
  }

  /** Real ends of all paths; `unresolved` counts those that neither end nor go to infinity, or share an end. */
  *_alongPaths(x) {
    let ends = [];
    for (const longest of LONGEST) {
      ends = yield* this._paths(x, ends, (start) => this._path(start, x, longest));
      if (!this._open(ends).some(Boolean)) break;
    }
    const count = (list) => this._open(list).filter(Boolean).length;
    if (count(ends)) {
      const others = yield* this._paths(x, [], (start) => this._detour(start, x));
      if (count(others) < count(ends)) ends = others;
    }
    this.unresolved = count(ends);
    const found = [];
    for (const end of ends) {
      const real = isFinite(end) && this._real(end, x);
      if (real && !found.some((other) => apart(this.model, this.coordinates, other, real, 1) < SAME[0])) found.push(real);
    }
    return found;
  }

  /** `end` of each start whose end so far is in doubt, a start at a time. */
  *_paths(x, before, end) {
    const open = this._open(before), ends = [...before];
    for (const [k, start] of this.starts.entries()) {
      if (before.length && !open[k]) continue;
      ends[k] = end(start);
      yield;
    }
    return ends;
  }

  /** Which paths are in doubt: those without an end, and those with the end of another. */
  _open(ends) {
    const same = (a, b) => apart(this.model, this.coordinates, a, b, 2) < SAME[1];
    return ends.map((end, k) => !end || (isFinite(end) && ends.some((other, j) => j !== k && isFinite(other) && same(other, end))));
  }

  _real(end, x) {
    const { columns } = this.model, real = Float64Array.from(x);
    for (const k of this.unknown) {
      if (Math.abs(end[2 * k + 1]) > REAL * columns[k] * (1 + Math.abs(end[2 * k] / columns[k]))) return null;
      real[k] = end[2 * k];
    }
    return standard(this.coordinates, real);
  }

  // --- paths -----------------------------------------------------------------------------------------------------------

  /** The path to the known values of x over other complex ones. */
  _detour(start, x) {
    const corner = Float64Array.from(start);
    this.known.forEach((k, i) => {
      corner[2 * k] = x[k] + 0.4 * this.model.columns[k] * Math.cos(5 * i + 1);
      corner[2 * k + 1] = 0.4 * this.model.columns[k] * Math.sin(5 * i + 1);
    });
    const half = this._along(start, corner, LONGEST[0]);
    return isFinite(half) ? this._path(half, x, LONGEST[0]) : half;
  }

  _path(start, x, longest) {
    const target = new Float64Array(start.length);
    x.forEach((v, k) => (target[2 * k] = v));
    return this._along(start, target, longest);
  }

  /** The end at the known values of `target` of the path from a start; INFINITE, or null where the steps become too short. */
  _along(start, target, longest) {
    const way = target.map((v, k) => v - start[k]);
    let t = 0, step = Math.min(0.1, longest), here = Float64Array.from(start);
    for (let steps = 0; t < 1; steps++) {
      if (steps > MOST_STEPS) return null;
      step = Math.min(step, 1 - t);
      const next = this._advance(here, start, way, t, step);
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
    return this._correct(here, 1e-13, 6) ? here : null;
  }

  /** Whether a solution has gone to infinity. */
  _far(x) {
    return this.coordinates.some(({ kind, place }) => {
      const k = 2 * place, size = Math.hypot(x[k], x[k + 1]);
      return kind === "angle" || kind === "turns" ? Math.abs(x[k + 1]) > FAR_ANGLE : size > FAR * this.model.columns[place];
    });
  }

  /** A step of Runge and Kutta's fourth order, then Newton's method; its first correction is the step's error. */
  _advance(x, start, way, t, step) {
    const slopes = [];
    for (const [share, before] of [[0, 0], [0.5, 0], [0.5, 1], [1, 2]]) {
      const at = share ? this.system.moved(x, slopes[before], share * step) : Float64Array.from(x);
      this.system.setKnown(at, start, way, t + share * step);
      const slope = this.system.tangent(at, way);
      if (!slope) return null;
      slopes.push(slope);
    }
    const mean = slopes[0].map((v, k) => (v + 2 * slopes[1][k] + 2 * slopes[2][k] + slopes[3][k]) / 6);
    const next = this.system.moved(x, mean, step);
    this.system.setKnown(next, start, way, step === 1 - t ? 1 : t + step);
    const error = this._correct(next, 1e-9, 3);
    return error && error < 2e-2 ? { x: next, error } : null;
  }

  /** Newton's method; lengths of its steps are shares of the solution's own where that is large. */
  _correct(x, close, most) {
    const { unknown, columns } = this.system, size = (at) => Math.max(1, ...unknown.map((k) => Math.abs(at[k]) / columns[k]));
    return this.system.newton(x, close, most, (length) => length < 10, size);
  }
}
