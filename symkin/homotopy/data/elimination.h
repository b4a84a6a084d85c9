/* Gauss elimination of n equations in n complex unknowns, n = UNKNOWNS, with two right sides, in all lanes at once.
 *
 * A row holds real and imaginary parts in turn: n coefficients, then the two right sides.
 */
#define PARTS (2 * UNKNOWNS)
#define ROW (2 * (UNKNOWNS + 2))
#define FAINT 1e-4 /* a pivot's squared share of the largest below which rows change places */

static inline v modulus2(const v *x) { return x[0] * x[0] + x[1] * x[1]; }

/* In lanes whose pivot is faint, the row of the largest one comes first, in each lane its own. */
static void exchange(v *a, int k)
{
    v *pivot = a + k * ROW, size = modulus2(pivot + 2 * k), largest = size;
    for (int i = k + 1; i < UNKNOWNS; i++)
        largest = larger(largest, modulus2(a + i * ROW + 2 * k));
    mask faint = size < FAINT * largest;
    if (!any(faint))
        return;
    for (int i = k + 1; i < UNKNOWNS; i++) {
        v *row = a + i * ROW, other = modulus2(row + 2 * k);
        mask swap = faint & (other > size);
        size = larger(size, other);
        for (int j = 2 * k; j < ROW; j++) {
            v x = pivot[j];
            pivot[j] = pick(swap, row[j], x), row[j] = pick(swap, x, row[j]);
        }
    }
}

/* The two last columns become the solutions. */
static void solve(v *a)
{
    for (int k = 0; k < UNKNOWNS; k++) {
        exchange(a, k);
        v *pivot = a + k * ROW, inverse = 1.0 / modulus2(pivot + 2 * k);
        v pr = pivot[2 * k] * inverse, pi = -pivot[2 * k + 1] * inverse;
        pivot[2 * k] = pr, pivot[2 * k + 1] = pi;
        for (int i = k + 1; i < UNKNOWNS; i++) {
            v *row = a + i * ROW;
            if (!any((row[2 * k] != 0.0) | (row[2 * k + 1] != 0.0)))
                continue;
            v lr = row[2 * k] * pr - row[2 * k + 1] * pi, li = row[2 * k] * pi + row[2 * k + 1] * pr;
            for (int j = 2 * k + 2; j < ROW; j += 2) {
                row[j] -= lr * pivot[j] - li * pivot[j + 1];
                row[j + 1] -= lr * pivot[j + 1] + li * pivot[j];
            }
        }
    }
    for (int k = UNKNOWNS - 1; k >= 0; k--)
        for (int side = PARTS; side < ROW; side += 2) {
            v *row = a + k * ROW, r = row[side], i = row[side + 1];
            for (int j = k + 1; j < UNKNOWNS; j++) {
                v *x = a + j * ROW + side;
                r -= row[2 * j] * x[0] - row[2 * j + 1] * x[1];
                i -= row[2 * j] * x[1] + row[2 * j + 1] * x[0];
            }
            row[side] = r * row[2 * k] - i * row[2 * k + 1];
            row[side + 1] = r * row[2 * k + 1] + i * row[2 * k];
        }
}
