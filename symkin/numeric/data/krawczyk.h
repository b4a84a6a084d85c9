/* Krawczyk's test with discs on lanes; read twice, after discs.h, with COMPLEX 0 and 1.
 *
 * Matrices hold NUMBER vectors for each entry, row by row.
 */
#define matrix(a, i, j) ((a) + ((i) * width + (j)) * NUMBER)

static inline v NAME(size)(const v *x)
{
#if COMPLEX
    v a = absolute(x[0]), b = absolute(x[1]);
    return 0.75 * (a + b) + 0.25 * absolute(a - b);
#else
    return absolute(x[0]);
#endif
}

/* sum += sign x y */
static inline void NAME(gather)(v *sum, const v *x, const v *y, double sign)
{
#if COMPLEX
    sum[0] += sign * (x[0] * y[0] - x[1] * y[1]);
    sum[1] += sign * (x[0] * y[1] + x[1] * y[0]);
#else
    sum[0] += sign * (x[0] * y[0]);
#endif
}

static inline void NAME(swap)(v *x, v *y, mask chosen, int count)
{
    for (int i = 0; i < count; i++) {
        v t = x[i];
        x[i] = pick(chosen, y[i], t), y[i] = pick(chosen, t, y[i]);
    }
}

/* About the inverse of a, which is lost, by Gauss and Jordan; each lane exchanges rows on its own. Nothing is proved of it. */
APART static void NAME(invert_matrix)(int width, v *a, v *inverse)
{
    int row = width * NUMBER;
    for (int i = 0; i < width; i++)
        for (int j = 0; j < row; j++)
            inverse[i * row + j] = all(j == i * NUMBER ? 1.0 : 0.0);
    for (int k = 0; k < width; k++) {
        v *pivot = a + k * row, *right = inverse + k * row, size = NAME(size)(matrix(a, k, k)), one[NUMBER], factor[NUMBER];
        for (int i = k + 1; i < width; i++) {
            v other = NAME(size)(matrix(a, i, k));
            mask chosen = other > size;
            size = pick(chosen, other, size);
            if (any(chosen)) {
                NAME(swap)(pivot + k * NUMBER, a + i * row + k * NUMBER, chosen, row - k * NUMBER);
                NAME(swap)(right, inverse + i * row, chosen, row);
            }
        }
#if COMPLEX
        v square = pivot[2 * k] * pivot[2 * k] + pivot[2 * k + 1] * pivot[2 * k + 1];
        one[0] = pivot[2 * k] / square, one[1] = -pivot[2 * k + 1] / square;
#else
        one[0] = 1.0 / pivot[k];
#endif
        for (int side = 0; side < 2; side++) {
            v *of = side ? right : pivot, was[NUMBER];
            for (int j = side ? 0 : k + 1; j < width; j++) {
                memcpy(was, of + j * NUMBER, sizeof was);
                memset(of + j * NUMBER, 0, sizeof was);
                NAME(gather)(of + j * NUMBER, one, was, 1.0);
            }
        }
        for (int i = 0; i < width; i++) {
            if (i == k)
                continue;
            memcpy(factor, matrix(a, i, k), sizeof factor);
            for (int j = k + 1; j < width; j++)
                NAME(gather)(matrix(a, i, j), factor, pivot + j * NUMBER, -1.0);
            for (int j = 0; j < width; j++)
                NAME(gather)(matrix(inverse, i, j), factor, right + j * NUMBER, -1.0);
        }
    }
}

/* What is known of one vector of points: the middles of dF/dz with the patch below, sums of the error bounds of each of its rows,
 * about its inverse, and the way of the points from where dF/dz was taken. */
struct NAME(matrices) {
    v *middles, *errors, *inverse, *moved;
};

APART static void NAME(fill)(const struct problem *p, struct NAME(matrices) to, const disc *slope, const double *patch, const int *of)
{
    int width = p->width, rows = p->value.outputs;
    double gamma = (2 * width + 8) * U;
    memset(to.middles, 0, width * width * NUMBER * sizeof(v));
    memset(to.errors, 0, width * sizeof(v));
    for (int i = 0; i < p->slope.outputs; i++, slope += VECTORS) {
        memcpy(matrix(to.middles, p->row[i], p->column[i]), &slope->re, NUMBER * sizeof(v));
        to.errors[p->row[i]] += slope->rad + gamma * NAME(modulus)(slope);
    }
    for (int j = 0; j < width && rows < width; j++) {
        v *entry = matrix(to.middles, rows, j);
        for (int l = 0; l < LANES; l++)
            for (int part = 0; part < NUMBER; part++)
                entry[part][l] = patch[((size_t)of[l] * width + j) * NUMBER + part];
        to.errors[rows] += gamma * NAME(size)(entry);
    }
}

/* A step of Newton's method from the points z, which are moved; `value` are the discs of F there. */
APART static void NAME(step)(const struct problem *p, struct NAME(matrices) at, const disc *value, disc *z)
{
    int width = p->width;
    for (int i = 0; i < width; i++) {
        v to[NUMBER], *part = &z[i * VECTORS].re;
        memcpy(to, part, sizeof to);
        for (int j = 0; j < p->value.outputs; j++)
            NAME(gather)(to, matrix(at.inverse, i, j), &value[j * VECTORS].re, -1.0);
        for (int k = 0; k < NUMBER; k++)
            at.moved[i * NUMBER + k] = to[k] - part[k];
        memcpy(part, to, sizeof to);
    }
}

/* The half width of a box about the points that holds one root of F, infinite where that is not shown.
 *
 * With Y any matrix, e_i >= sum_j |1 - Y F'|_ij and s_i >= |Y F(centre)|_i, the operator x - Y F(x) takes the numbers within
 * 1.5 rho of the centre to those within s_i + e_i 1.5 rho. If this is less than rho, and F' was bounded on all of them, which lie
 * within `wide` of the first points, then F has one root there, at which F' is regular since e_i < 1. It is 1.5 rho because a
 * square of half width rho lies in the disc of that radius: the root is the only one in the square, too.
 *
 * A sum of n products of middles, in whatever order, is off by less than GAMMA = (2 n + 8) u times the sum of the products' sizes
 * (real n u, complex (1.5 n + 3) u, and terms in u^2). MANY outweighs the roundings of sums and products of numbers that are not
 * negative, fewer than 3 n + 100 one after another, for n <= 64. Products of f and F' with u may lose 2^-1074 by underflow, which
 * an entry of Y below LARGEST makes less than FLOOR. */
APART static v NAME(radius)(const struct problem *p, struct NAME(matrices) at, const disc *value, double wide, v *e, v *s)
{
    int width = p->width;
    double gamma = (2 * width + 8) * U;
    v rho = all(0.0), bad = all(0.0);
    for (int i = 0; i < width; i++) {
        v step[NUMBER], sum[NUMBER];
        memset(step, 0, sizeof step);
        e[i] = all(FLOOR), s[i] = all(FLOOR);
        for (int j = 0; j < width; j++) {
            memset(sum, 0, sizeof sum);
            for (int k = 0; k < width; k++)
                NAME(gather)(sum, matrix(at.inverse, i, k), matrix(at.middles, k, j), 1.0);
            sum[0] = sum[0] - (i == j ? 1.0 : 0.0);
            v weight = NAME(size)(matrix(at.inverse, i, j));
            e[i] += NAME(size)(sum) + weight * at.errors[j];
            bad = pick(weight < LARGEST, bad, all(1.0));
        }
        for (int j = 0; j < p->value.outputs; j++) {
            const disc *f = value + j * VECTORS;
            NAME(gather)(step, matrix(at.inverse, i, j), &f->re, 1.0);
            s[i] += NAME(size)(matrix(at.inverse, i, j)) * (f->rad + gamma * NAME(modulus)(f));
        }
        e[i] = e[i] * MANY, s[i] = (s[i] + NAME(size)(step)) * MANY;
        bad = pick(e[i] < 0.6, bad, all(1.0));
        rho = larger(rho, s[i] / (0.98 - 1.5 * e[i]));
    }
    rho = rho * (1.0 + 0x1p-40);
    for (int i = 0; i < width; i++) {
        bad = pick((s[i] + e[i] * (1.5 * rho)) * UP < rho, bad, all(1.0));
        bad = pick((NAME(size)(at.moved + i * NUMBER) + 1.5 * rho) * UP <= wide, bad, all(1.0));
    }
    return pick(bad == 0.0, rho, all(INFINITY));
}

/* Discs of one entry of a block: `parts` are the middles of entry `entry` of `count`, `radii` theirs or null; point of a lane by
 * `of`. */
APART static void NAME(load)(disc *out, const double *parts, const double *radii, int count, int entry, const int *of)
{
    for (int l = 0; l < VECTORS * LANES; l++) {
        disc *x = out + l / LANES;
        const double *part = parts + ((size_t)of[l] * count + entry) * NUMBER;
        x->re[l % LANES] = part[0];
#if COMPLEX
        x->im[l % LANES] = part[1];
#endif
        x->rad[l % LANES] = radii ? radii[(size_t)of[l] * count + entry] : 0.0;
    }
}

/* A tape for n points z (n, width) with radii (n, width), and `kept` entries of their instances; results (n, outputs). */
APART static int NAME(run_all)(int n, int width, int kept, const struct code *code, const double *z,
                                                   const double *radii, const double *known, const double *spread,
                                                   const int *instance, double *middle, double *radius)
{
    disc *input = reserve(sizeof *input * VECTORS * (width + kept + code->places + code->outputs));
    disc *place = input + (width + kept) * VECTORS, *output = place + code->places * VECTORS;
    if (!input)
        return 0;
    for (int begin = 0; begin < n; begin += BLOCK) {
        int of[BLOCK], at[BLOCK];
        choose(n, begin, instance, of, at);
        for (int i = 0; i < width; i++)
            NAME(load)(input + i * VECTORS, z, radii, width, i, of);
        for (int i = 0; i < kept; i++)
            NAME(load)(input + (width + i) * VECTORS, known, spread, kept, i, at);
        NAME(run)(code, input, place, output);
        for (int i = 0; i < code->outputs; i++)
            for (int l = 0; l < BLOCK && begin + l < n; l++) {
                size_t to = (size_t)(begin + l) * code->outputs + i;
                const disc *x = output + i * VECTORS + l / LANES;
                for (int part = 0; part < NUMBER; part++)
                    middle[to * NUMBER + part] = (&x->re)[part][l % LANES];
                radius[to] = x->rad[l % LANES];
            }
    }
    free(input);
    return 1;
}

/* A Newton step from each point z (n, width) and the test about the new point: `centre` and the half width of its box, infinite
 * where nothing is shown. Where the rows of F are one fewer than the unknowns, `patch` (n, width) is the last row of dF/dz, and
 * x is sought with patch (x - centre) = 0. */
APART static int NAME(enclose_all)(const struct problem *p, int n, const double *z, const double *patch,
                                                       const double *known, const double *spread, const int *instance,
                                                       double wide, double *centre, double *half_width)
{
    int width = p->width, kept = p->before.outputs, rows = p->value.outputs, square = width * width * NUMBER;
    int places = p->value.places > p->slope.places ? p->value.places : p->slope.places;
    size_t discs = (size_t)VECTORS * (width + kept + places + rows + p->slope.outputs);
    size_t own = 2 * square + width * (NUMBER + 1), shared = square + 2 * width;
    disc *input = reserve(discs * sizeof *input + (VECTORS * own + shared) * sizeof(v));
    if (!input)
        return 0;
    disc *place = input + (width + kept) * VECTORS, *value = place + places * VECTORS, *slope = value + rows * VECTORS;
    v *lost = (v *)(input + discs), *e = lost + square, *s = e + width, *matrices = s + width;
    for (int begin = 0; begin < n; begin += BLOCK) {
        int of[BLOCK], at[BLOCK];
        struct NAME(matrices) with[VECTORS];
        choose(n, begin, instance, of, at);
        for (int i = 0; i < kept; i++)
            NAME(load)(input + (width + i) * VECTORS, known, spread, kept, i, at);
        for (int i = 0; i < width; i++)
            NAME(load)(input + i * VECTORS, z, 0, width, i, of);
        NAME(run)(&p->value, input, place, value);
        for (int i = 0; i < width * VECTORS; i++)
            input[i].rad = all(wide);
        NAME(run)(&p->slope, input, place, slope);
        for (int i = 0; i < width * VECTORS; i++)
            input[i].rad = all(0.0);
        for (int l = 0; l < VECTORS; l++) {
            v *own_matrices = matrices + l * own;
            with[l] = (struct NAME(matrices)){own_matrices, own_matrices + 2 * square, own_matrices + square,
                                              own_matrices + 2 * square + width};
            NAME(fill)(p, with[l], slope + l, patch, of + l * LANES);
            memcpy(lost, with[l].middles, square * sizeof(v));
            NAME(invert_matrix)(width, lost, with[l].inverse);
            NAME(step)(p, with[l], value + l, input + l);
        }
        NAME(run)(&p->value, input, place, value);
        for (int l = 0; l < VECTORS; l++) {
            v found = NAME(radius)(p, with[l], value + l, wide, e, s);
            for (int k = 0, to = begin + l * LANES; k < LANES && to < n; k++, to++) {
                half_width[to] = found[k];
                for (int i = 0; i < width * NUMBER; i++)
                    centre[(size_t)to * width * NUMBER + i] = (&input[i / NUMBER * VECTORS + l].re)[i % NUMBER][k];
            }
        }
    }
    free(input);
    return 1;
}
#undef NAME
#undef NUMBER
#undef disc
#undef matrix
