// Dense linear algebra: least squares by Householder's QR with column pivots, singular vectors by iteration.

const RANK = 1e-13; // pivots below this share of the first are zero

/** Solve min |A y - b| for A (m, n) row by row, by QR; null where numbers are not finite. Columns without a pivot get zero; of a matrix
 * of full rank pivots need not be sought. */
export function leastSquares(a, b, n, pivoted = true) {
  const m = n ? a.length / n : 0, y = new Float64Array(n);
  if (!n) return y;
  const { pivots, rank } = reduce(a, b, m, n, 1, pivoted);
  substitute(a, b, y, n, 1, 0, pivots, rank);
  return y.every(Number.isFinite) ? y : null;
}

/** The length of Y (Frobenius) with A Y = B - A in least squares for A, B (m, n): below 1, no matrix between A and B on a straight line
 * loses rank. Infinity where A has lost it. A and B are overwritten. */
export function relativeChange(a, b, n) {
  const m = n ? a.length / n : 0, y = new Float64Array(n);
  for (let k = 0; k < b.length; k++) b[k] -= a[k];
  const { pivots, rank } = reduce(a, b, m, n, n, true);
  if (rank < n) return Infinity;
  let sum = 0;
  for (let column = 0; column < n; column++) {
    substitute(a, b, y, n, n, column, pivots, rank);
    for (const v of y) sum += v * v;
  }
  return Math.sqrt(sum);
}

/** Solve the triangle for one column of b (m, width). */
function substitute(a, b, y, n, width, column, pivots, rank) {
  for (let k = rank - 1; k >= 0; k--) {
    let sum = b[k * width + column];
    for (let j = k + 1; j < rank; j++) sum -= a[k * n + pivots[j]] * y[pivots[j]];
    y[pivots[k]] = sum / a[k * n + pivots[k]];
  }
}

/** Reduce A to a triangle in place (its columns in the order of `pivots`), b (m, width) with it. */
function reduce(a, b, m, n, width, pivoted) {
  const pivots = Array.from({ length: n }, (_, k) => k), most = Math.min(m, n);
  let first = 0, rank = 0;
  for (; rank < most; rank++) {
    let best = rank, norm = -1;
    for (let j = rank; j < (pivoted ? n : rank + 1); j++) {
      let sum = 0;
      for (let r = rank; r < m; r++) sum += a[r * n + pivots[j]] ** 2;
      if (sum > norm) [best, norm] = [j, sum];
    }
    norm = Math.sqrt(norm);
    if (rank === 0) first = norm;
    if (!(norm > RANK * first)) break;
    [pivots[rank], pivots[best]] = [pivots[best], pivots[rank]];
    reflect(a, b, m, n, width, pivots[rank], rank, norm);
  }
  return { pivots, rank };
}

/** Reflect the rows from k on so that column p of A is zero below row k. */
function reflect(a, b, m, n, width, p, k, norm) {
  const head = a[k * n + p], alpha = head > 0 ? -norm : norm;
  const v = new Float64Array(m - k);
  for (let r = k; r < m; r++) v[r - k] = a[r * n + p];
  v[0] = head - alpha;
  const beta = v.reduce((sum, c) => sum + c * c, 0);
  if (beta === 0) return;
  for (const [matrix, columns] of [[a, n], [b, width]])
    for (let j = 0; j < columns; j++) {
      let dot = 0;
      for (let r = k; r < m; r++) dot += v[r - k] * matrix[r * columns + j];
      dot *= 2 / beta;
      for (let r = k; r < m; r++) matrix[r * columns + j] -= dot * v[r - k];
    }
}

/** Smallest and largest singular value of A (m, n), and the right singular vector of the smallest, by Jacobi's turns. */
export function singularPair(a, m, n) {
  const v = new Float64Array(n * n);
  const w = Float64Array.from(a);
  for (let k = 0; k < n; k++) v[k * n + k] = 1;
  // one-sided Jacobi: columns of W = A V are made orthogonal
  for (let sweep = 0; sweep < 30; sweep++) {
    let off = 0;
    for (let i = 0; i < n; i++) for (let j = i + 1; j < n; j++) off = Math.max(off, orthogonalise(w, v, m, n, i, j));
    if (off < 1e-14) break;
  }
  const norms = Array.from({ length: n }, (_, k) => {
    let sum = 0;
    for (let r = 0; r < m; r++) sum += w[r * n + k] ** 2;
    return Math.sqrt(sum);
  });
  const least = norms.indexOf(Math.min(...norms)), most = Math.max(...norms);
  return { least: m < n ? 0 : norms[least], most, vector: Array.from({ length: n }, (_, k) => v[k * n + least]) };
}

function orthogonalise(w, v, m, n, i, j) {
  let aa = 0, bb = 0, ab = 0;
  for (let r = 0; r < m; r++) {
    aa += w[r * n + i] ** 2;
    bb += w[r * n + j] ** 2;
    ab += w[r * n + i] * w[r * n + j];
  }
  const scale = Math.sqrt(aa * bb);
  if (scale === 0 || Math.abs(ab) <= 1e-15 * scale) return 0;
  const zeta = (bb - aa) / (2 * ab), t = Math.sign(zeta || 1) / (Math.abs(zeta) + Math.sqrt(1 + zeta * zeta));
  const c = 1 / Math.sqrt(1 + t * t), s = c * t;
  for (const [x, rows] of [[w, m], [v, n]]) {
    for (let r = 0; r < rows; r++) {
      const p = x[r * n + i], q = x[r * n + j];
      x[r * n + i] = c * p - s * q;
      x[r * n + j] = s * p + c * q;
    }
  }
  return Math.abs(ab) / scale;
}
