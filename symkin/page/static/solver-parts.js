// A linear system whose rows and unknowns fall into parts that share none: legs that only the base joins. Parts are solved one by one.
import { leastSquares, relativeChange, singularPair } from "solver-algebra";

export class Parts {
  /** Rows' gradients (m, width) hold NaN where an entry is always zero; `unknown` are the columns that are solved for. */
  constructor(gradients, width, unknown) {
    this.width = width;
    this.unknown = unknown;
    const rows = Array.from({ length: gradients.length / width }, (_, r) => r);
    const entries = rows.map((r) => unknown.flatMap((place, k) => (Number.isNaN(gradients[r * width + place]) ? [] : [k])));
    const leader = unknown.map((_, k) => k), find = (k) => (leader[k] === k ? k : (leader[k] = find(leader[k])));
    for (const [first, ...others] of entries) for (const k of others) leader[find(k)] = find(first);
    this.parts = unknown.map((_, k) => k).filter((k) => find(k) === k).map((root) => ({
      rows: rows.filter((r) => entries[r].length && find(entries[r][0]) === root),
      columns: unknown.map((_, k) => k).filter((k) => find(k) === root),
    }));
  }

  /** The parts' matrices of gradients. */
  matrices(gradients) {
    return this.parts.map(({ rows, columns }) => {
      const matrix = new Float64Array(rows.length * columns.length);
      let place = 0;
      for (const r of rows) for (const k of columns) matrix[place++] = gradients[r * this.width + this.unknown[k]];
      return matrix;
    });
  }

  /** Unknowns of least squares for a right side of all rows; null where numbers are not finite. The matrices are overwritten. */
  solve(matrices, right, pivoted = true) {
    const y = new Float64Array(this.unknown.length);
    for (const [i, { rows, columns }] of this.parts.entries()) {
      const found = leastSquares(matrices[i], Float64Array.from(rows, (r) => right[r]), columns.length, pivoted);
      if (!found) return null;
      columns.forEach((k, j) => (y[k] = found[j]));
    }
    return y;
  }

  /** `relativeChange` of the whole. Both lists of matrices are overwritten. */
  change(before, after) {
    return Math.hypot(...this.parts.map(({ columns }, i) => relativeChange(before[i], after[i], columns.length)));
  }

  /** Smallest over largest singular value of the whole, and the unknowns' motion of the smallest. */
  singularPair(matrices) {
    const pairs = this.parts.map(({ rows, columns }, i) => singularPair(matrices[i], rows.length, columns.length));
    if (!pairs.length) return { ratio: 1, vector: new Float64Array(0) };
    const least = pairs.reduce((best, pair, i) => (pair.least < pairs[best].least ? i : best), 0);
    const most = Math.max(...pairs.map((pair) => pair.most)), vector = new Float64Array(this.unknown.length);
    this.parts[least].columns.forEach((k, j) => (vector[k] = pairs[least].vector[j]));
    return { ratio: most > 0 ? pairs[least].least / most : 0, vector };
  }
}
