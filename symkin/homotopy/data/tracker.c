/* Path tracking with a path in each lane: roots of F(z, k) = 0 while k = begin + s along, s from 0 to 1.
 *
 * closure.h, generated from the closure, has the system: UNKNOWNS, rows as many as unknowns (with the patch row of a
 * projective point), and what further rows leave. A lane extrapolates Hermite's polynomial through its last points and
 * tangents dz/ds, then corrects by Newton; all lanes share each evaluation and elimination, whether they correct a new
 * prediction or an old one. A lane whose path has ended takes the next path. A projective point moves within the
 * hyperplane patch . z = 1, renewed where the point has turned away from it.
 */
#include "lanes.h"

#include "closure.h"
#include "elimination.h"

#define POINTS 3   /* points and tangents that the predictor keeps */
#define TURNED 1.3 /* |z|^2 beyond which the patch is renewed; it is 1 at renewal */
#define TURN 6.283185307179586
#define LIMIT 1e30 /* a Newton step beyond is not finite */

typedef struct {
    double tolerance, accepted, polished, left, first_step, smallest_step, longest, aim;
    int most_steps, corrections, polishing;
} settings;

typedef struct {
    int path[LANES];                      /* number of the path in each lane, -1 for none */
    mask busy;                            /* lanes that have one */
    v begin[2 * KNOWN], along[2 * KNOWN]; /* its line k = begin + s along */
    v z[PARTS], patch[PARTS];             /* the point that is corrected */
    v at, corrected, first, last;         /* its s, Newton steps so far, their first and last relative sizes */
    v s, h, count, tries;                 /* where the path has come, its step, points kept, predictions made */
    v point_s[POINTS], point[POINTS][PARTS], tangent[POINTS][PARTS]; /* those points, newest first */
} lanes;

typedef struct {
    v dz[PARTS], tangent[PARTS], size, left; /* Newton step, dz/ds, relative size of the step, largest row squared */
} linear;

static inline v norm2(const v *x)
{
    v sum = all(0.0);
    for (int i = 0; i < PARTS; i++)
        sum += x[i] * x[i];
    return sum;
}

static inline v largest_row(const v *a, v largest)
{
    for (int i = 0; i < UNKNOWNS; i++)
        largest = larger(largest, modulus2(a + i * ROW + PARTS));
    return largest;
}

/* patch . z = 1 as a row of the linear system */
static void patch_row(const v *z, const v *patch, v *row)
{
    row[PARTS] = all(-1.0), row[PARTS + 1] = row[PARTS + 2] = row[PARTS + 3] = all(0.0);
    for (int i = 0; i < PARTS; i += 2) {
        row[i] = patch[i], row[i + 1] = patch[i + 1];
        row[PARTS] += patch[i] * z[i] - patch[i + 1] * z[i + 1];
        row[PARTS + 1] += patch[i] * z[i + 1] + patch[i + 1] * z[i];
    }
}

/* The Newton step of every lane and the tangent, from one matrix. */
static void linearise(const lanes *l, linear *out)
{
    v a[UNKNOWNS * ROW], further = all(0.0);
    evaluate(l->z, l->at, l->begin, l->along, a, &further);
    if (PROJECTIVE)
        patch_row(l->z, l->patch, a + (UNKNOWNS - 1) * ROW);
    out->left = largest_row(a, further);
    solve(a);
    for (int i = 0; i < PARTS; i++) {
        out->dz[i] = -a[i / 2 * ROW + PARTS + i % 2];
        out->tangent[i] = -a[i / 2 * ROW + PARTS + 2 + i % 2];
    }
    out->size = root(norm2(out->dz) / larger(norm2(l->z), all(1.0)));
}

/* --- prediction ------------------------------------------------------------------------------------------------- */

/* Points p and tangents t of the lanes `who` in the patch conj(x)/|x|, x the newest ray:
 * p / (c.p) and t / (c.p) - p (c.t) / (c.p)^2. */
static void renew_patch(lanes *l, mask who)
{
    v length = all(0.0);
    for (int i = 0; i < PARTS; i++)
        if (in_ray[i / 2])
            length += l->point[0][i] * l->point[0][i];
    length = 1.0 / root(length);
    for (int i = 0; i < PARTS; i++)
        if (in_ray[i / 2])
            l->patch[i] = pick(who, (i % 2 ? -length : length) * l->point[0][i], l->patch[i]);
    for (int n = 0; n < POINTS; n++) {
        v *p = l->point[n], *t = l->tangent[n], pr = all(0.0), pi = pr, tr = pr, ti = pr;
        for (int i = 0; i < PARTS; i += 2) {
            v cr = l->patch[i], ci = l->patch[i + 1];
            pr += cr * p[i] - ci * p[i + 1], pi += cr * p[i + 1] + ci * p[i];
            tr += cr * t[i] - ci * t[i + 1], ti += cr * t[i + 1] + ci * t[i];
        }
        mask kept = who & (l->count > (double)n);
        v inverse = 1.0 / (pr * pr + pi * pi), ir = pr * inverse, ii = -pi * inverse;
        v ur = tr * ir - ti * ii, ui = tr * ii + ti * ir;
        for (int i = 0; i < PARTS; i += 2)
            if (in_ray[i / 2]) {
                v xr = p[i] * ir - p[i + 1] * ii, xi = p[i] * ii + p[i + 1] * ir;
                v yr = t[i] * ir - t[i + 1] * ii - (ur * xr - ui * xi), yi = t[i] * ii + t[i + 1] * ir - (ur * xi + ui * xr);
                p[i] = pick(kept, xr, p[i]), p[i + 1] = pick(kept, xi, p[i + 1]);
                t[i] = pick(kept, yr, t[i]), t[i + 1] = pick(kept, yi, t[i + 1]);
            }
    }
}

/* Patches of those lanes `who` whose ray has turned away; results of a path do not depend on its neighbours. */
static void renew_turned_patches(lanes *l, mask who)
{
    v length = all(0.0);
    for (int i = 0; i < PARTS; i++)
        if (in_ray[i / 2])
            length += l->point[0][i] * l->point[0][i];
    who &= length > TURNED;
    if (any(who))
        renew_patch(l, who);
}

/* Hermite's polynomial at s = l->at: the sum over points j of ((1 - 2 (s - s_j) q_j) p_j + (s - s_j) t_j) b_j^2 with
 * b_j = prod (s - s_m) / (s_j - s_m) and q_j = sum 1 / (s_j - s_m) over the other points m. */
static void predict(lanes *l, mask who)
{
    v of_point[POINTS], of_tangent[POINTS];
    for (int j = 0; j < POINTS; j++) {
        v from = l->at - l->point_s[j], basis = all(1.0), sum = all(0.0);
        for (int m = 0; m < POINTS; m++) {
            if (m == j)
                continue;
            mask kept = l->count > (double)(m > j ? m : j);
            v inverse = 1.0 / pick(kept, l->point_s[j] - l->point_s[m], all(1.0));
            basis *= pick(kept, (l->at - l->point_s[m]) * inverse, all(1.0));
            sum += pick(kept, inverse, all(0.0));
        }
        basis = pick(l->count > (double)j, basis * basis, all(0.0));
        of_point[j] = (1.0 - 2.0 * from * sum) * basis, of_tangent[j] = from * basis;
    }
    for (int i = 0; i < PARTS; i++) {
        v z = all(0.0);
        for (int j = 0; j < POINTS; j++)
            z += of_point[j] * l->point[j][i] + of_tangent[j] * l->tangent[j][i];
        l->z[i] = pick(who, z, l->z[i]);
    }
}

/* prod (h + s_0 - s_j) over the points kept, the root of what the error grows with, and its derivative. */
static v distance_product(const lanes *l, v h, v *rate)
{
    v product = all(1.0), slope = all(0.0);
    for (int j = 0; j < POINTS; j++) {
        mask kept = l->count > (double)j;
        v d = h + (l->point_s[0] - l->point_s[j]);
        slope = pick(kept, slope * d + product, slope);
        product = pick(kept, product * d, product);
    }
    *rate = slope;
    return product;
}

/* The step, at most `cap`, at which the distance product is `wanted`: Newton on a convex function, from above. */
static v step_for(const lanes *l, v wanted, v cap)
{
    v h = cap, rate;
    for (int i = 0; i < 4; i++) {
        v product = distance_product(l, h, &rate);
        h = pick(product > wanted, h - (product - wanted) / rate, h);
    }
    return h;
}

/* --- paths ------------------------------------------------------------------------------------------------------ */

/* A point with its ray of unit length. */
static void unit_ray(double *to, const double *z)
{
    double sum = 0.0;
    for (int i = 0; i < PARTS; i++)
        sum += in_ray[i / 2] ? z[i] * z[i] : 0.0;
    sum = __builtin_sqrt(sum);
    for (int i = 0; i < PARTS; i++)
        to[i] = in_ray[i / 2] ? z[i] / sum : z[i];
}

/* The same with angles within half a turn of zero. */
static void standard(double *to, const double *z)
{
    unit_ray(to, z);
    for (int i = 0; i < UNKNOWNS; i++)
        if (is_angle[i])
            to[2 * i] -= TURN * __builtin_rint(to[2 * i] / TURN);
}

static void take_path(lanes *l, int i, int path, const double *from, const double *begin, const double *along, double first_step)
{
    double z[PARTS];
    standard(z, from);
    l->path[i] = path, l->busy[i] = -1;
    for (int j = 0; j < 2 * KNOWN; j++)
        l->begin[j][i] = begin[j], l->along[j][i] = along ? along[j] : 0.0;
    for (int j = 0; j < PARTS; j++) {
        l->z[j][i] = l->point[0][j][i] = z[j], l->tangent[0][j][i] = 0.0;
        l->patch[j][i] = in_ray[j / 2] ? (j % 2 ? -z[j] : z[j]) : 0.0;
    }
    for (int j = 0; j < POINTS; j++)
        l->point_s[j][i] = 0.0;
    l->s[i] = l->at[i] = l->count[i] = l->tries[i] = l->corrected[i] = l->first[i] = l->last[i] = 0.0;
    l->h[i] = first_step;
}

static void leave_path(lanes *l, int i, double *z, double *s, int *tries)
{
    int path = l->path[i];
    for (int j = 0; j < PARTS; j++)
        z[path * PARTS + j] = l->point[0][j][i];
    unit_ray(z + path * PARTS, z + path * PARTS);
    s[path] = l->s[i], tries[path] = (int)l->tries[i];
    l->path[i] = -1, l->busy[i] = 0;
}

/* The corrected points of the lanes `who` become their newest ones. */
static void keep(lanes *l, mask who, const v *tangent)
{
    for (int n = POINTS - 1; n > 0; n--) {
        l->point_s[n] = pick(who, l->point_s[n - 1], l->point_s[n]);
        for (int i = 0; i < PARTS; i++) {
            l->point[n][i] = pick(who, l->point[n - 1][i], l->point[n][i]);
            l->tangent[n][i] = pick(who, l->tangent[n - 1][i], l->tangent[n][i]);
        }
    }
    l->point_s[0] = pick(who, l->at, l->point_s[0]);
    for (int i = 0; i < PARTS; i++) {
        l->point[0][i] = pick(who, l->z[i], l->point[0][i]);
        l->tangent[0][i] = pick(who, tangent[i], l->tangent[0][i]);
    }
    l->s = pick(who, l->at, l->s);
    l->count = pick(who, smaller(l->count + 1.0, all(POINTS)), l->count);
}

/* Corrects every lane once; `good` are the lanes whose point has settled, `bad` those whose prediction was too far. */
static void correct(lanes *l, const linear *step, const settings *set, mask *good, mask *bad)
{
    mask at_end = l->at >= 1.0, at_start = l->count == 0.0, is_first = l->corrected == 0.0;
    mask settled = step->size <= pick(at_end, all(set->polished), all(set->accepted));
    settled &= ~at_end | (step->left <= set->left * set->left);
    mask too_far = (is_first & ~at_start & (step->size > set->tolerance)) | (~is_first & (step->size > 0.5 * l->last));
    l->corrected += 1.0;
    v most = pick(at_end | at_start, all(set->polishing), all(set->corrections));
    too_far |= ~(step->size < LIMIT) | (~settled & (l->corrected >= most));
    l->first = pick(is_first, step->size, l->first), l->last = step->size;
    for (int i = 0; i < PARTS; i++)
        l->z[i] = pick(too_far, l->z[i], l->z[i] + step->dz[i]);
    *good = l->busy & settled & ~too_far, *bad = l->busy & too_far;
}

/* Keeps good points and chooses the next step: the error grows with the square of the distance product, and the first
 * correction is its measure. With few points the order is still rising, and the step follows a fourth root. */
static void advance(lanes *l, const linear *step, const settings *set, mask good, mask bad)
{
    v h = l->at - l->s, rate, ratio = root(set->aim / larger(l->first, all(1e-18)));
    ratio = pick(l->first < LIMIT, ratio, all(1e-3));
    v wanted = distance_product(l, h, &rate) * ratio, cap = h * pick(good, all(set->longest), all(0.5));
    mask few = l->count < (double)POINTS, stays = ~(good | bad) | (l->count == 0.0);
    keep(l, good, step->tangent);
    v next = pick(few, smaller(cap, pick(good, h, 0.5 * h) * root(ratio)), step_for(l, wanted, cap));
    l->h = pick(stays, l->h, larger(next, 0.1 * h));
    l->tries += (v)((mask)all(1.0) & (good | bad));
}

static mask ended(const lanes *l, const settings *set, mask good, mask bad)
{
    mask given_up = (l->h <= set->smallest_step) | (l->tries >= (double)set->most_steps) | (l->count == 0.0);
    return (good & (l->s >= 1.0)) | ((good | bad) & given_up);
}

static void aim_ahead(lanes *l, mask who)
{
    v next = l->s + l->h;
    next = pick(next + 0.1 * l->h >= 1.0, all(1.0), next);
    l->at = pick(who, next, l->at);
    l->corrected = pick(who, all(0.0), l->corrected);
    if (PROJECTIVE)
        renew_turned_patches(l, who);
    predict(l, who);
}

/* Tracks n roots z and writes where each path came: z at the last point kept, rays of unit length, its s, predictions
 * made. begin and along are those of all paths, or of each if `each`. */
void symkin_track(int n, const double *z, const double *begin, const double *along, int each, const settings *set, double *end,
                  double *s, int *tries)
{
    lanes l;
    linear step;
    mask good, bad;
    int next = 0;
    __builtin_memset(&l, 0, sizeof l);
    for (int i = 0; i < LANES; i++)
        l.path[i] = -1;
    for (;;) {
        for (int i = 0; i < LANES && next < n; i++)
            if (l.path[i] < 0) {
                int k = each ? next * 2 * KNOWN : 0;
                take_path(&l, i, next, z + next * PARTS, begin + k, along + k, set->first_step), next++;
            }
        if (!any(l.busy))
            return;
        linearise(&l, &step);
        correct(&l, &step, set, &good, &bad);
        if (!any(good | bad))
            continue;
        advance(&l, &step, set, good, bad);
        mask over = ended(&l, set, good, bad);
        for (int i = 0; i < LANES; i++)
            if (over[i])
                leave_path(&l, i, end, s, tries);
        aim_ahead(&l, (good | bad) & ~over);
    }
}

/* Newton from n points z, to rays of unit length and angles within half a turn of zero, at the k of all of them, or of
 * each if `each`; `last` are the sizes of the last steps, infinite where rows stay. */
void symkin_newton(int n, const double *z, const double *k, int each, int iterations, double left, double *end, double *last)
{
    lanes l;
    linear step;
    __builtin_memset(&l, 0, sizeof l);
    for (int first = 0; first < n; first += LANES) {
        int here = n - first < LANES ? n - first : LANES;
        v size = all(0.0);
        for (int i = 0; i < LANES; i++) {
            int from = first + (i < here ? i : 0);
            take_path(&l, i, from, z + from * PARTS, k + (each ? from * 2 * KNOWN : 0), 0, 0.0);
        }
        for (int m = 0; m < iterations; m++) {
            linearise(&l, &step);
            mask finite = step.size < LIMIT;
            for (int i = 0; i < PARTS; i++)
                l.z[i] = pick(finite, l.z[i] + step.dz[i], l.z[i]);
            size = pick(finite & (step.left <= left * left), step.size, all(__builtin_inf()));
            if (!any((size >= 1e-13) & finite))
                break;
        }
        for (int i = 0; i < here; i++) {
            for (int j = 0; j < PARTS; j++)
                end[(first + i) * PARTS + j] = l.z[j][i];
            standard(end + (first + i) * PARTS, end + (first + i) * PARTS);
            last[first + i] = size[i];
        }
    }
}
