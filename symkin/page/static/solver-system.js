// Rows of a closure and their gradients: tangents and Newton's method for the unknowns at known values.
import { leastSquares, relativeChange, singularPair } from "solver-algebra";

const ROUNDING = 1e-7; // Newton's step below which it need not contract: near a singularity rounding is that large
const numbers = (count) => [...Array(count).keys()];

export class System {
  /** `evaluate(x, values, gradients)` fills the rows and what of their gradients is not always zero, by x in units of `columns`. `parts`
   * share neither rows nor unknowns, as legs that only the base joins, and are solved one by one. */
  constructor(evaluate, { rows, columns, known, unknown, pivoted = true, parts = [{ rows: numbers(rows), columns: numbers(unknown.length) }] }) {
    Object.assign(this, { evaluate, columns, known, unknown, pivoted });
    this.values = new Float64Array(rows);
    this.gradients = new Float64Array(rows * columns.length);
    const entry = (r, k) => r * columns.length + unknown[k];
    this.parts = parts.map((part) => ({ ...part, entries: part.rows.flatMap((r) => part.columns.map((k) => entry(r, k))) }));
  }

  /** Rows and the unknowns' columns of their Jacobian, part by part. */
  linearise(x) {
    this.evaluate(x, this.values, this.gradients);
    return this.parts.map(({ entries }) => {
      const matrix = new Float64Array(entries.length);
      entries.forEach((entry, i) => (matrix[i] = this.gradients[entry]));
      return matrix;
    });
  }

  /** Unknowns of least squares for a right side of all rows; null where numbers are not finite. The matrices are overwritten. */
  solve(matrices, right) {
    const y = new Float64Array(this.unknown.length);
    for (const [i, { rows, columns }] of this.parts.entries()) {
      const found = leastSquares(matrices[i], Float64Array.from(rows, (r) => right[r]), columns.length, this.pivoted);
      if (!found) return null;
      columns.forEach((k, j) => (y[k] = found[j]));
    }
    return y;
  }

  /** `relativeChange` of the whole Jacobian from one configuration to another. */
  change(before, after) {
    const [a, b] = [before, after].map((x) => this.linearise(x));
    return Math.hypot(...this.parts.map(({ columns }, i) => relativeChange(a[i], b[i], columns.length)));
  }

  /** Smallest over largest singular value of the whole, and the unknowns' motion of the smallest. */
  singularPair(x) {
    const matrices = this.linearise(x), vector = new Float64Array(this.unknown.length);
    const pairs = this.parts.map(({ rows, columns }, i) => singularPair(matrices[i], rows.length, columns.length));
    if (!pairs.length) return { ratio: 1, vector };
    const least = pairs.reduce((best, pair, i) => (pair.least < pairs[best].least ? i : best), 0);
    const most = Math.max(...pairs.map((pair) => pair.most));
    this.parts[least].columns.forEach((k, j) => (vector[k] = pairs[least].vector[j]));
    return { ratio: most > 0 ? pairs[least].least / most : 0, vector };
  }

  /** The unknowns' velocity, in units of their columns, while known values move by `way` in a unit of time; null where it is not finite. */
  tangent(x, way) {
    const matrices = this.linearise(x), width = this.columns.length, right = this.values.map(() => 0);
    for (let r = 0; r < right.length; r++)
      for (const k of this.known) right[r] -= (this.gradients[r * width + k] * way[k]) / this.columns[k];
    return this.solve(matrices, right);
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
      const matrices = this.linearise(x), step = this.solve(matrices, this.values.map((v) => -v));
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
