// Rows of a closure and their gradients: tangents and Newton's method for the unknowns at known values.
import { Parts } from "solver-parts";

const ROUNDING = 1e-7; // Newton's step below which it need not contract: near a singularity rounding is that large

export class System {
  /** `evaluate(x, values, gradients)` fills the rows and what of their gradients is not always zero, by x in units of `columns`. */
  constructor(evaluate, { rows, columns, known, unknown, pivoted = true }) {
    Object.assign(this, { evaluate, columns, known, unknown, pivoted });
    this.values = new Float64Array(rows);
    this.gradients = new Float64Array(rows * columns.length).fill(NaN);
    this.parts = null; // once rows have been evaluated
  }

  /** Rows and the unknowns' columns of their Jacobian, part by part. */
  linearise(x) {
    this.evaluate(x, this.values, this.gradients);
    if (!this.parts) {
      this.parts = new Parts(this.gradients, this.columns.length, this.unknown);
      this.gradients.fill(0);
      this.evaluate(x, this.values, this.gradients);
    }
    return this.parts.matrices(this.gradients);
  }

  /** The unknowns' velocity, in units of their columns, while known values move by `way` in a unit of time; null where it is not finite. */
  tangent(x, way) {
    const matrices = this.linearise(x), width = this.columns.length, right = this.values.map(() => 0);
    for (let r = 0; r < right.length; r++)
      for (const k of this.known) right[r] -= (this.gradients[r * width + k] * way[k]) / this.columns[k];
    return this.parts.solve(matrices, right, this.pivoted);
  }

  /** A copy of x with its unknowns moved for some time. */
  moved(x, velocity, time) {
    const next = Float64Array.from(x);
    this.unknown.forEach((place, i) => (next[place] += time * velocity[i] * this.columns[place]));
    return next;
  }

  setKnown(x, start, way, time) {
    for (const k of this.known) x[k] = start[k] + time * way[k];
  }

  /** Newton's method in place until a step is below `close` or is rounding; the first step's length (at least 1e-300), 0 where it fails or
   * a step's length is none that is allowed after the last one. Lengths are shares of unit(x). */
  newton(x, close, most, allowed, unit = () => 1) {
    let first = 0, last = Infinity;
    for (let k = 0; k < most; k++) {
      const matrices = this.linearise(x), step = this.parts.solve(matrices, this.values.map((v) => -v), this.pivoted);
      const length = step ? Math.hypot(...step) / unit(x) : Infinity;
      if (!Number.isFinite(length) || !allowed(length, last)) return 0;
      x.set(this.moved(x, step, 1));
      if (k === 0) first = Math.max(length, 1e-300);
      if (length <= close || (length < ROUNDING && length > 0.5 * last)) return first;
      last = length;
    }
    return last < ROUNDING ? first : 0;
  }
}

/** A system over complex numbers, held as pairs, as a real one of twice the size: gradients a + ib are [[a, -b], [b, a]]. */
export function complexSystem(evaluate, { rows, columns, known, unknown }) {
  const width = columns.length, found = new Float64Array(2 * rows * width).fill(NaN), pairs = (k) => [2 * k, 2 * k + 1];
  let entries = null;
  const evaluatePairs = (x, values, gradients) => {
    evaluate(x, values, found);
    entries ??= [...found.keys()].filter((k) => k % 2 === 0 && !Number.isNaN(found[k]));
    for (const k of entries) {
      const above = k + 2 * width * Math.floor(k / (2 * width)), below = above + 2 * width;
      gradients[above] = gradients[below + 1] = found[k];
      gradients[below] = found[k + 1];
      gradients[above + 1] = -found[k + 1];
    }
  };
  const sizes = { rows: 2 * rows, columns: columns.flatMap((v) => [v, v]), known: known.flatMap(pairs), unknown: unknown.flatMap(pairs) };
  return new System(evaluatePairs, { ...sizes, pivoted: false }); // paths from generic values keep full rank
}
