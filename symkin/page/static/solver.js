// Follows a mechanism's closure: Newton's method on all rows with step control, all modes, the inverse problem of a drag.
// No imports but the linear algebra; plain numbers; runs in browsers and in node alike.
import { leastSquares } from "solver-algebra";
import { beyond, plainValue, positive } from "solver-coordinates";
import { Roots } from "solver-roots";
import { System } from "solver-system";

const NEWTON = 12; // iterations at most
const CLOSED = 1e-13; // Newton's step, over the size, at which a configuration is closed
const ROUNDING = 1e-7; // Newton's step, over the size, below which rounding may keep it from contracting
const REACH = 0.12; // of a step in units of the size and radians
const CORRECTION = 0.25; // share of a predicted step that Newton may add to it
const CONTRACTION = 0.2; // of Newton's second step over its first
const CHANGE = 0.7; // of the Jacobian in a step, relative to itself: from 1 on it may lose rank within the step
const AHEAD = 1e-3; // of a look beyond a stop, in units of the size and radians
const SMALLEST = 2e-8; // share of a movement below which a step is given up
const ESCAPE = 1e-14; // the same for first steps, which lead away from a singularity
const AT_LIMIT = 1e-12; // the same where a limit lies ahead
const FARTHEST = 1e3; // longest movement, over the size or in radians
const NEAR = 0.05; // the same at a halt, below which it is told as a singularity
const STANDS = 1e-3; // share of a motion below which the platform, or a joint, stands in it

export function createSolver(model, generated) {
  return new Solver(model, generated);
}

class Solver {
  constructor(model, generated) {
    this.model = model;
    this.functions = generated;
    this.size = model.size;
    this.names = model.names;
    this.units = model.units;
    this.limits = model.limits;
    this.links = model.links;
    this.x = Float64Array.from(model.start);
    this.unknown = model.unknown;
    const places = new Map(model.coordinates.map((c) => [c.name, c.place]));
    this.places = this.names.map((name) => places.get(name));
    this.kinds = this.names.map((name) => model.coordinates.find((c) => c.name === name).kind);
        this.system = new System(generated.system, { ...model, known: this.places });
    this.limited = model.limited.map((c) => ({ ...c, high: c.high ?? Infinity }));
    this.heedsLimits = true; // whether movements stop at limits
    this.correct(this.x);
    this.roots = new Roots(this);
    this.modeIndex = -1;
    this.found = this.search = null; // the modes at the present values, and the search for them
  }

  /** What joints read whose coordinates the closure leaves out. */
  _read(x) {
    const values = new Float64Array(4 * this.model.readings.length);
    this.functions.readings(x, values);
    return values;
  }

  // --- values --------------------------------------------------------------------------------------------------------

  get values() {
    return Object.fromEntries(this.names.map((name, k) => [name, this._out(this.kinds[k], this.x[this.places[k]])]));
  }

  _out(kind, value) {
    return (kind === "angle" || kind === "turns") && this.model.angleUnit === "deg" ? (value * 180) / Math.PI : value;
  }

  _in(kind, value) {
    return (kind === "angle" || kind === "turns") && this.model.angleUnit === "deg" ? (value * Math.PI) / 180 : value;
  }

  /** Move in a straight line to values by name. */
  set(values) {
    const target = Float64Array.from(this.x);
    for (const [name, value] of Object.entries(values)) {
      const k = this.names.indexOf(name);
      if (k < 0) throw new Error(`${JSON.stringify(name)} is not given here; allowed: ${this.names.join(", ")}`);
      if (typeof value !== "number" || !Number.isFinite(value)) throw new Error(`${name} = ${value} is not a finite number`);
      target[this.places[k]] = this._in(this.kinds[k], value);
    }
    return this.goTo(target);
  }

  /** The same to the known values of a target in radians and lengths; the stop is told with its sentence, motion and place. */
  goTo(target) {
    const { x, share, halt } = this.follow(this.x, target), moved = this._apart(this.x, x);
    if (halt?.kind === "halt") halt.meets = this._goesOn(x, target);
    this.x = x;
    this.found = this.search = null;
    return { reached: !halt, share, stop: halt ? this._stop(halt, share, moved, this._movedAlone(target)) : null };
  }

  // --- following -----------------------------------------------------------------------------------------------------

  /** From a configuration to the known values of a target: {x, share, halt}, halt null where they were reached. */
  follow(from, target) {
    const way = target.map((value, k) => value - from[k]), length = this._apart(from, target);
    let x = Float64Array.from(from), share = 0;
    if (length === 0) return { x, share: 1, halt: null };
    if (length > FARTHEST) return this._followPart(from, way, (0.999 * FARTHEST) / length);
    const allowed = this._excesses(x);
    let step = Math.min(1, REACH / length), least = ESCAPE, limit = null;
    while (share < 1) {
      if (share + step > 1) step = 1 - share;
      const next = this._advance(x, way, from, share, step), excesses = next && this._excesses(next);
      const left = next && this.heedsLimits && this._limitLeft(excesses, allowed);
      if (left) [limit, least] = [left, AT_LIMIT];
      const leaves = step >= SMALLEST || limit || (next && this._ratio(next) > this._ratio(x));
      if (next && !left && leaves) {
        x = next;
        excesses.forEach((v, k) => Math.abs(v) < Math.abs(allowed[k]) && (allowed[k] = v));
        share = step === 1 - share ? 1 : share + step;
        if (step >= SMALLEST && !limit) least = SMALLEST;
        step = Math.min(2 * step, REACH / length);
        if (1 - share - step < SMALLEST) step = 1 - share;
        continue;
      }
      step *= 0.5;
      if (step < least) return { x, share, halt: { kind: limit ? "limit" : "halt", limit } };
    }
    return { x, share: 1, halt: null };
  }

  /** The one given coordinate that is still to move to a target, null where more are. */
  _movedAlone(target) {
    const left = this.names.filter((name, k) => Math.abs(target[this.places[k]] - this.x[this.places[k]]) > 1e-12 * this.model.columns[this.places[k]]);
    return left.length === 1 ? left[0] : null;
  }

  /** Whether a solution lies straight beyond a stop, as where branches meet, not where two solutions end in each other. */
  _goesOn(x, target) {
    const length = this._apart(x, target);
    if (length < 2 * AHEAD) return false;
    const { x: before, halt } = this.follow(x, x.map((v, k) => v - (AHEAD / length) * (target[k] - v)));
    if (halt) return false;
    const guess = x.map((v, i) => 2 * v - before[i]);
    const beyond = Float64Array.from(guess), apart = (a, b) => Math.hypot(...this.unknown.map((i) => (a[i] - b[i]) / this.model.columns[i]));
    return this.correct(beyond) && apart(beyond, guess) < 0.1 * apart(beyond, before);
  }

  /** The first part of a movement that is too long for one. */
  _followPart(from, way, part) {
    const { x, share, halt } = this.follow(from, from.map((v, k) => v + part * way[k]));
    return { x, share: part * share, halt: halt ?? { kind: "far" } };
  }

  /** How far the given coordinates of two configurations are apart, over the size and in radians. */
  _apart(x, y) {
    return Math.hypot(...this.places.map((place) => (y[place] - x[place]) / this.model.columns[place]));
  }

  /** One step: tangent, then Newton; null where the corrector does not contract as near a regular configuration, and where a singular
   * one may lie within the step. */
  _advance(x, way, start, share, step) {
    const { system } = this, tangent = system.tangent(x, way);
    if (!tangent) return null;
    const reach = step * Math.hypot(...tangent);
    if (!(reach < 2 * REACH)) return null;
    const next = system.moved(x, tangent, step);
    system.setKnown(next, start, way, step === 1 - share ? 1 : share + step);
    const known = this._apart(x, next);
    if (!this.correct(next, CORRECTION * (reach + known) + ROUNDING)) return null;
    return system.change(x, next) < CHANGE ? next : null;
  }

  /** Newton's method on the unknowns of x, in place; whether it closed, its first step within `most` and contracting. */
  correct(x, most = Infinity) {
    const contracts = (length, last) => length <= Math.max(CONTRACTION * last, ROUNDING);
    const allowed = (length, last) => most === Infinity || (last === Infinity ? length <= most : contracts(length, last));
    return this.system.newton(x, CLOSED, NEWTON, allowed) > 0 && this._closed(x);
  }

  /** Rows that are not zero remain where known values contradict each other. */
  _closed(x) {
    this.system.evaluate(x, this.system.values, this.system.gradients);
    return this.system.values.every((v) => Math.abs(v) < this.model.tolerances.closure);
  }

  // --- limits --------------------------------------------------------------------------------------------------------

  /** A coordinate that is further beyond its limits than is allowed, null where none is. */
  _limitLeft(excesses, allowed) {
    // what lies beyond already may stay there; what is at its limit does not creep on
    const kept = (c, k) => (excesses[k] * allowed[k] > 0 && Math.abs(allowed[k]) > c.slack ? Math.abs(allowed[k]) + c.slack : 0);
    const left = (c, k) => Math.abs(excesses[k]) > Math.max(c.slack, kept(c, k));
    const k = this.limited.findIndex(left);
    if (k < 0) return null;
    const { name, kind, low, high, slack } = this.limited[k];
    return { name, kind, value: excesses[k] > 0 ? high : low, beyond: Math.abs(allowed[k]) > 2 * slack };
  }

  /** How far each coordinate of `limited` is beyond its limits, below zero under the lower one. */
  _excesses(x) {
    const values = this.limited.some((c) => c.read) ? this._read(x) : null;
    return this.limited.map((c) => beyond(c, (c.read ? values : x)[c.place]));
  }

  // --- stops ---------------------------------------------------------------------------------------------------------

  _stop(halt, share, moved, alone) {
    const where = alone ? `at ${alone} = ${Number(this.values[alone].toPrecision(6))} ${this.units[alone]}, ` : "";
    const after = share < 1e-4 && moved < 1e-3 ? "Stopped at once" : `Stopped ${where}after ${percent(share)} of the way`;
    if (halt.kind === "far") {
      const cause = ": that is too far for one movement.";
      return { kind: "lost", sentence: after + cause, cause, motion: null, ratio: this.distanceToSingularity() };
    }
    if (halt.limit) {
      const value = this._out(halt.limit.kind, halt.limit.value), unit = this.units[halt.limit.name] ?? "";
      const stands = halt.limit.beyond ? "lies beyond" : "is at";
      const cause = `: ${halt.limit.name} ${stands} its limit of ${Number(value.toPrecision(6))} ${unit}.`;
      return { kind: "limit", sentence: after + cause, cause, motion: null, limit: { name: halt.limit.name, value } };
    }
    const ratio = this.distanceToSingularity(), { motion, sentence: moves } = this._singularMotion();
    const ends = halt.meets ? "branches meet here, of which the page chooses none: symkin modes lists them beyond" : "beyond it this mode does not go on";
    const cause = ratio < NEAR ? `, at a singularity: ${moves}, and ${ends}.` : ": this mode cannot be followed further.";
    return { kind: ratio < NEAR ? "singularity" : "lost", sentence: after + cause, cause, motion: ratio < NEAR ? motion : null, ratio };
  }

  /** What `set` would stop at where the mechanism stands: null where it is regular. */
  stopHere() {
    const ratio = this.distanceToSingularity();
    if (ratio === null || ratio >= this.model.tolerances.singular) return null;
    const { motion, sentence } = this._singularMotion();
    const where = "begin elsewhere, with --joints, --given, or [example] in the file";
    return { kind: "singularity", sentence: `This configuration is singular: ${sentence}, so that no movement is followed from it; ${where}.`, motion, ratio };
  }

  /** Smallest singular value of the unknowns' Jacobian over the largest, lengths over the size. */
  distanceToSingularity() {
    return this.unknown.length ? this._ratio(this.x) : null;
  }

  _ratio(x) {
    return this.system.singularPair(x).ratio;
  }

  /** The motion that the given values hold least: the platform's twist (velocity, angular velocity; null where it stands), and in words. */
  _singularMotion() {
    const { vector } = this.system.singularPair(this.x);
    const twist = this.model.hasPlatform ? this._twists(this.x).map((row) => this.unknown.reduce((sum, place, k) => sum + row[place] * vector[k], 0)) : null, length = (k) => (k < 3 ? 1 / this.size : 1);
    const motion = twist && Math.hypot(...twist.map((v, k) => v * length(k))) > STANDS ? twist : null;
    const rates = this.model.coordinates.flatMap((c) => {
      const k = this.unknown.indexOf(c.place);
      return k < 0 || c.kind === "quaternion" || c.name.startsWith("pose.") ? [] : [[c.name, Math.abs(vector[k])]];
    });
    const most = Math.max(...rates.map(([, rate]) => rate)), named = rates.filter(([, rate]) => rate > 0.3 * most && most > STANDS).slice(0, 3);
    const what = motion || !named.length ? "the mechanism" : named.map(([name]) => name).join(", ");
    return { motion, sentence: `${what} can move a little while the given values are held${motion ? ", as the arrow shows" : ""}` };
  }

  /** The platform's pose [position, quaternion]. */
  _pose(x) {
    const pose = new Float64Array(7);
    this.functions.pose(x, pose);
    return [[...pose.subarray(0, 3)], positive(pose.subarray(3))];
  }

  /** Rates of its twist (velocity, angular velocity) with the variables, row by row. */
  _twists(x) {
    const { width } = this.model, gradients = new Float64Array(6 * width);
    this.functions.twist(x, gradients);
    return Array.from({ length: 6 }, (_, r) => gradients.subarray(r * width, (r + 1) * width));
  }

  /** How far a given coordinate may move from here, the others held: [low, high] within the limits or `ends`. */
  rangeLeft(name, ends) {
    const k = this.names.indexOf(name), limits = ends ?? this.limits[name];
    const half = this.kinds[k] === "length" ? 0.5 * this.size : Math.PI;
    const place = this.places[k];
    return [0, 1].map((side) => {
      const end = limits?.[side] ?? null;
      const target = Float64Array.from(this.x);
      target[place] = end === null ? target[place] + (side ? half : -half) : this._in(this.kinds[k], end);
      return this._out(this.kinds[k], this.follow(this.x, target).x[place]);
    });
  }

  // --- solutions -----------------------------------------------------------------------------------------------------

  /** Pose, joints and residual of a configuration, the present one unless told. */
  solution(x = this.x) {
    const joints = {}, { functions, model } = this;
    let within = null;
    const tell = (list, values) => {
      for (const c of list) {
        const value = plainValue(c, values);
        joints[c.name] = this._out(c.kind, value);
        if (c.limits) within = within !== false && value >= c.limits[0] - c.slack && value <= c.limits[1] + c.slack;
      }
    };
    tell(model.readings, this._read(x));
    tell(model.coordinates.filter((c) => c.joint), x);
    const errors = new Float64Array(model.errors);
    functions.errors(x, errors);
    const residual = errors.reduce((most, v) => Math.max(most, Math.abs(v)), 0);
    const [position, quaternion] = model.hasPlatform ? this._pose(x) : [null, null];
    return { position, quaternion, joints, residual, within_limits: within, variables: Array.from(x) };
  }

  /** Search for all modes at the present values for some milliseconds; whether they are found. */
  findModes(milliseconds) {
    if (this.found) return true;
    const end = performance.now() + milliseconds;
    this.search ??= this.roots.search(this.x);
    do {
      const { done, value } = this.search.next();
      if (done) [this.found, this.search] = [this._differentFirst(value), null];
    } while (!this.found && performance.now() < end);
    return this.found !== null;
  }

  /** The modes with one at each pose and set of actuated joints before all others. */
  _differentFirst(list) {
    if (!this.model.hasPlatform) return list;
    const seen = [], first = [], others = [];
    for (const x of list) {
      const mark = this._markOf(x), known = seen.some((one) => one.every((v, k) => Math.abs(v - mark[k]) < this.model.tolerances.same));
      (known ? others : first).push(x);
      if (!known) seen.push(mark);
    }
    return [...first, ...others];
  }

  /** Pose and actuated joints of a configuration: lengths over the size, angles by cosine and sine. */
  _markOf(x) {
    const { size, model } = this, [position, quaternion] = this._pose(x);
    const joints = model.coordinates.filter((c) => c.actuated).flatMap((c) => {
      const v = x[c.place];
      return c.kind === "angle" ? [Math.cos(v), Math.sin(v)] : [c.kind === "length" ? v / size : v];
    });
    return [...position.map((v) => v / size), ...quaternion, ...joints];
  }

  /** All modes at the present values; waits for the end of the search. */
  modes() {
    this.findModes(Infinity);
    this.modeIndex = this.roots.indexOf(this.found, this.x);
    return this.found.map((x) => this.solution(x));
  }

  get modesComplete() {
    return this.roots.complete;
  }

  get modesSentence() {
    return this.roots.sentence;
  }

  /** Take the configuration of the start. */
  takeStart() {
    this.x = Float64Array.from(this.model.start);
    this.found = this.search = null;
  }

  choose(index) {
    const list = this.found ?? (this.modes(), this.found);
    if (!Number.isInteger(index) || index < 0 || index >= list.length) return false;
    this.x = Float64Array.from(list[index]);
    this.modeIndex = index;
    return true;
  }

  /** Poses of the links, 12 numbers each: rows of [R|t]. */
  linkPoses(solution) {
    const matrices = new Float64Array(12 * this.links.length);
    this.functions.links(solution?.variables ?? this.x, matrices);
    return matrices;
  }

  // --- dragging ------------------------------------------------------------------------------------------------------

  /** Go towards a pose of the platform as near as the closure lets it, in steps that keep the mode. */
  dragTo(position, quaternion, rounds = 6) {
    let result = { reached: true, share: 1, stop: null };
    for (let round = 0; round < rounds && this.names.length; round++) {
      const target = this._towards(position, quaternion);
      if (!target) break;
      result = this.goTo(target);
      if (!result.reached) break;
    }
    return result;
  }

  /** Known values a step nearer to the pose, by least squares on pose, rows and a small step; null where that moves nothing. */
  _towards(position, quaternion) {
    const { width, columns } = this.model, [here, turned] = this._pose(this.x), twists = this._twists(this.x);
    const { values: rows, gradients: closing } = this.system;
    this.system.evaluate(this.x, rows, closing);
    const away = position.map((v, k) => (v - here[k]) / this.size);
    if (quaternion) away.push(...rotationVector(quaternion, turned));
    const matrix = new Float64Array((rows.length + away.length + width) * width), right = new Float64Array(matrix.length / width);
    const stiff = 1e4;
    closing.forEach((v, k) => (matrix[k] = stiff * v));
    let row = rows.length;
    for (const [k, v] of away.entries()) {
      matrix.set(twists[k].map((rate) => (k < 3 ? rate / this.size : rate)), row * width);
      right[row++] = v;
    }
    for (let c = 0; c < width; c++) matrix[(row + c) * width + c] = 3e-3;
    const step = leastSquares(matrix, right, width);
    if (!step) return null;
    const length = Math.hypot(...step);
    if (length < 1e-6) return null;
    const part = Math.min(1, 0.3 / length);
    const target = Float64Array.from(this.x);
    this.places.forEach((place, k) => (target[place] = this._clamped(this.names[k], target[place] + part * step[place] * columns[place])));
    return target;
  }

  _clamped(name, value) {
    if (!this.heedsLimits) return value;
    const { low, high } = this.limited.find((one) => one.name === name) ?? { low: -Infinity, high: Infinity };
    return Math.min(high, Math.max(low, value));
  }
}

// --- numbers ---------------------------------------------------------------------------------------------------------

/** A share as a text: of 1, what is left of it is told too. */
export function percent(share) {
  const near = share > 0.999 ? Number((100 - Number((100 * (1 - share)).toPrecision(1))).toPrecision(10)) : Number((100 * share).toPrecision(3));
  return `${near} %`;
}

/** The rotation vector that turns the second orientation into the first. */
function rotationVector([aw, ax, ay, az], [bw, bx, by, bz]) {
  let w = aw * bw + ax * bx + ay * by + az * bz;
  let v = [-aw * bx + ax * bw - ay * bz + az * by, -aw * by + ax * bz + ay * bw - az * bx, -aw * bz - ax * by + ay * bx + az * bw];
  if (w < 0) [w, v] = [-w, v.map((c) => -c)];
  const sine = Math.hypot(...v);
  return v.map((c) => (sine > 1e-12 ? (2 * Math.atan2(sine, w) * c) / sine : 2 * c));
}
