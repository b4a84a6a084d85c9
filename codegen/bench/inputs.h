/* Random inputs for every function of a generated folder, and their calls; what is done before and after each is the including file's.
 *
 * Macros: NAME, UPPER (the mechanism's name), HEADER, VECTORS (files to include), SERIAL, PARALLEL or MAP, STRUCT where the geometry is
 * given with each call, HAS_... for each function beyond these. The including file defines `begin`, `finish` and `end` before it calls `call_all`:
 * begin(), the call, finish(), end(function's number, its name, status, whether what OK came with is finite, number of the input). */
#include HEADER
#include VECTORS
#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define F(what) JOIN(NAME, _##what)
#define M(what) JOIN(UPPER, _##what)
#define N M(JOINTS)
#ifdef STRUCT
static const F(geometry) nominal = M(NOMINAL);
#define FIRST &nominal,
#else
#define FIRST
#endif
#ifdef MAP
#define FOUND M(FOUND)
#else
#define FOUND 1
#endif
#define KINDS 10
#define MOST_FUNCTIONS 12

typedef F(real) real;

/* What a call is given. */
typedef struct {
    real joints[N];
    real guess[N];
    real found[FOUND]; /* of a map, as the next two */
    real found_guess[FOUND];
    real found_rates[FOUND];
    real rates[N];
    real twist[6];
    real limits[N];
#ifndef MAP
    F(pose) pose;
#endif
    F(config) config;
    int usual; /* whether the call has no config */
} inputs;

static unsigned long long state;

static unsigned long long next(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return state;
}

/* -1 to 1 */
static double uniform(void)
{
    return (double)(next() >> 11) * 0x1p-53 * 2.0 - 1.0;
}

/* A finite number of any size. */
static real any_size(void)
{
    const double most = log10(sizeof(real) == 4 ? (double)FLT_MAX : DBL_MAX);
    const double least = log10(sizeof(real) == 4 ? 1e-45 : 5e-324);
    const double size = pow(10.0, least + (most - least) * 0.4999 * (uniform() + 1.0));
    return (real)((next() % 2ULL == 0ULL) ? size : -size);
}

/* NaN, infinities, zeros, the largest and least numbers, or a number of any size. */
static real special(void)
{
    const double most = sizeof(real) == 4 ? (double)FLT_MAX : DBL_MAX;
    const double least = sizeof(real) == 4 ? 1e-45 : 5e-324;
    const double values[10] = { NAN, INFINITY, -INFINITY, 0.0, -0.0, most, -most, least, -least, 1.0 };
    const unsigned long long kind = next() % 14ULL;
    return (kind < 10ULL) ? (real)values[kind] : any_size();
}

static real ordinary_or_special(double scale)
{
    return (next() % 4ULL == 0ULL) ? special() : (real)(scale * uniform());
}

/* Multiples of an eighth turn or of a quarter of the size: where linear systems lose rank. */
static real lattice(double step)
{
    const double off = (next() % 2ULL == 0ULL) ? 0.0 : pow(10.0, -8.0 - 8.0 * fabs(uniform())) * uniform();
    return (real)(step * (double)((int)(next() % 17ULL) - 8) + off);
}

#ifdef MAP
static void of_vector(inputs *in, double relative)
{
    const int k = (int)(next() % (unsigned long long)M(VECTORS));
    for (int i = 0; i < N; ++i) {
        in->joints[i] = (real)((double)F(vector_joints)[k][i] + relative * uniform());
        in->guess[i] = (real)((double)F(vector_joints)[k][i] + relative * uniform());
    }
    for (int i = 0; i < FOUND; ++i) {
        in->found[i] = (real)((double)F(vector_found)[k][i] + relative * uniform());
        in->found_guess[i] = (real)((double)F(vector_found)[k][i] + relative * uniform());
    }
}

static void all_by(inputs *in, real (*number)(double), double angle, double length)
{
    for (int i = 0; i < N; ++i) {
        in->joints[i] = number((next() % 4ULL != 0ULL) ? angle : length);
        in->guess[i] = number(angle);
    }
    for (int i = 0; i < FOUND; ++i) {
        in->found[i] = number((next() % 4ULL != 0ULL) ? angle : length);
        in->found_guess[i] = number(angle);
    }
}
#else
static void of_vector(inputs *in, double relative)
{
    const int k = (int)(next() % (unsigned long long)M(VECTORS));
    for (int i = 0; i < N; ++i) {
        in->joints[i] = (real)((double)F(vector_joints)[k][i] * (1.0 + relative * uniform()));
#ifdef SERIAL
        in->guess[i] = (real)((double)F(vector_guesses)[k][i] * (1.0 + relative * uniform()));
#endif
    }
    for (int i = 0; i < 3; ++i) {
        in->pose.position[i] = (real)((double)F(vector_poses)[k][i] + (double)M(SIZE) * relative * uniform());
    }
    for (int i = 0; i < 4; ++i) {
        in->pose.quaternion[i] = (real)((double)F(vector_poses)[k][3 + i] + fmin(relative, 2e-3) * uniform());
    }
}

/* Every number of the joints, the guess and the position by a function of its scale, the quaternion of unit length. */
static void all_by(inputs *in, real (*number)(double), double angle, double length)
{
    double q[4], squared = 0.0;
    for (int i = 0; i < N; ++i) {
        in->joints[i] = number((next() % 2ULL == 0ULL) ? angle : length);
        in->guess[i] = number(angle);
    }
    for (int i = 0; i < 3; ++i) {
        in->pose.position[i] = number(length);
    }
    for (int i = 0; i < 4; ++i) {
        q[i] = (double)number(1.0);
        squared += q[i] * q[i];
    }
    for (int i = 0; i < 4; ++i) {
        in->pose.quaternion[i] = (real)((squared > 1e-6 && squared < 1e6) ? q[i] / sqrt(squared) : (double)(i == 0));
    }
}
#endif

/* Values on the line from one vector's to another's and up to some times its length beyond, so that many lines end where the machine
 * cannot go and are cut until a config's iterations are used up. */
static void of_line(inputs *in)
{
    const unsigned long long count = (unsigned long long)M(VECTORS);
    const int a = (int)(next() % count), b = (int)(next() % count), c = (int)(next() % count);
    const double reach = 4.0 * pow(10.0, -2.0 * fabs(uniform())) * uniform();
    for (int i = 0; i < N; ++i) {
        const double from = (double)F(vector_joints)[a][i], to = (double)F(vector_joints)[b][i];
        in->joints[i] = (real)(from + reach * (to - from));
        in->guess[i] = (real)((next() % 2ULL == 0ULL) ? (double)F(vector_joints)[c][i] : from - reach * (to - from));
    }
#ifdef MAP
    for (int i = 0; i < FOUND; ++i) {
        const double from = (double)F(vector_found)[a][i], to = (double)F(vector_found)[b][i];
        in->found[i] = (real)(from + reach * (to - from));
        in->found_guess[i] = F(vector_found)[c][i];
    }
#else
    for (int i = 0; i < 3; ++i) {
        in->pose.position[i] = F(vector_poses)[c][i];
    }
    for (int i = 0; i < 4; ++i) {
        in->pose.quaternion[i] = F(vector_poses)[c][3 + i];
    }
#endif
}

/* Whole turns away from a vector's values: sines of large angles take longest. */
static void of_turns(inputs *in)
{
    const double turn = 6.283185307179586;
    of_vector(in, pow(10.0, -6.0 * fabs(uniform())));
    for (int i = 0; i < N; ++i) {
        in->joints[i] += (real)(turn * floor(160.0 * uniform()));
        in->guess[i] += (real)(turn * floor(160.0 * uniform()));
    }
    for (int i = 0; i < FOUND; ++i) {
        in->found[i] += (real)(turn * floor(160.0 * uniform()));
        in->found_guess[i] += (real)(turn * floor(160.0 * uniform()));
    }
}

static real ordinary(double scale)
{
    return (real)(scale * uniform());
}

static real finite_any(double scale)
{
    (void)scale;
    return any_size();
}

static void fill(inputs *in, int kind)
{
    const double size = (double)M(SIZE);
    of_vector(in, 0.0);
    if (kind == 0) {
        all_by(in, ordinary_or_special, 3.2, 2.0 * size);
#ifndef MAP
        for (int i = 0; i < 4; ++i) {
            in->pose.quaternion[i] = ordinary_or_special(1.0);
        }
#endif
    } else if (kind == 1) {
        all_by(in, ordinary_or_special, 3.2, 2.0 * size);
    } else if (kind == 2) {
        of_vector(in, pow(10.0, -12.0 * fabs(uniform())));
    } else if (kind == 3) {
#ifdef MAP
        const int slot = (int)(next() % (unsigned long long)(2 * N + FOUND));
        real *const place = (slot < N) ? &in->joints[slot] : (slot < 2 * N) ? &in->guess[slot - N] : &in->found[slot - 2 * N];
#else
        const int slot = (int)(next() % (unsigned long long)(2 * N + 7));
        real *const place = (slot < N) ? &in->joints[slot] : (slot < 2 * N) ? &in->guess[slot - N]
            : (slot < 2 * N + 3) ? &in->pose.position[slot - 2 * N] : &in->pose.quaternion[slot - 2 * N - 3];
#endif
        of_vector(in, 1e-3);
        *place = special();
    } else if (kind == 4) {
        all_by(in, ordinary, 3.2, 1.5 * size);
    } else if (kind == 5) {
        all_by(in, lattice, 0.78539816339744831, 0.25 * size);
    } else if (kind == 6) {
        all_by(in, finite_any, 1.0, 1.0);
    } else if (kind == 8) {
        of_line(in);
    } else if (kind == 9) {
        of_turns(in);
    } else {
        of_vector(in, pow(10.0, -3.0 * fabs(uniform())));
        for (int i = 0; i < N; ++i) {
            in->guess[i] = (next() % 2ULL == 0ULL) ? in->joints[i] : lattice(0.78539816339744831);
        }
    }
    for (int i = 0; i < 6; ++i) {
        in->twist[i] = (kind % 2 == 0) ? ordinary_or_special(size) : ordinary(size);
    }
    for (int i = 0; i < FOUND; ++i) {
        in->found_rates[i] = (kind % 2 == 0) ? ordinary_or_special(size) : ordinary(size);
    }
    for (int i = 0; i < N; ++i) {
        in->rates[i] = (kind % 2 == 0) ? ordinary_or_special(size) : ordinary(size);
        in->limits[i] = (kind % 2 == 0) ? ordinary_or_special(size) : (real)(0.1 * size * fabs(uniform()));
    }
    in->usual = (next() % 4ULL != 0ULL);
    in->config.tolerance = (next() % 2ULL == 0ULL) ? M(TOLERANCE) : special();
    in->config.max_iterations = (uint8_t)((next() % 2ULL == 0ULL) ? M(MAX_STEPS) : next() % 256ULL);
    in->config.max_step = (next() % 2ULL == 0ULL) ? M(MAX_STEP) : special();
}

static int all_finite(const real *v, int n)
{
    for (int i = 0; i < n; ++i) {
        if (!isfinite(v[i])) {
            return 0;
        }
    }
    return 1;
}

#ifndef MAP
static int pose_finite(const F(pose) * pose)
{
    return all_finite(pose->position, 3) && all_finite(pose->quaternion, 4);
}
#endif

static int inputs_finite(const inputs *in)
{
#ifdef MAP
    const int others = all_finite(in->found, FOUND) && all_finite(in->found_guess, FOUND) && all_finite(in->found_rates, FOUND);
#else
    const int others = pose_finite(&in->pose);
#endif
    return all_finite(in->joints, N) && all_finite(in->guess, N) && all_finite(in->rates, N) && all_finite(in->twist, 6)
        && all_finite(in->limits, N) && others && isfinite(in->config.tolerance) && isfinite(in->config.max_step);
}

static int of_finite; /* whether this input has finite numbers only */

static void begin(void);
static void finish(void);
static void end(int function, const char *name, int status, int finite, long number);

#define CALL(name, finite, ...)                                        \
    do {                                                                \
        int status;                                                     \
        begin();                                                        \
        status = (int)F(name)(FIRST __VA_ARGS__);                       \
        finish();                                                       \
        end(function++, #name, status, status != 0 || (finite), number); \
    } while (0)

#ifdef MAP
static void call_all(const inputs *in, long number)
{
    const F(config) *const config = in->usual ? NULL : &in->config;
    real joints[N], found[FOUND], matrix[FOUND * N], second[FOUND * N * N];
    F(info) info;
    int function = 0;
    memset(joints, 0, sizeof joints);
    memset(found, 0, sizeof found);
    memset(matrix, 0, sizeof matrix);
    memset(second, 0, sizeof second);
    of_finite = inputs_finite(in);
    CALL(direct, all_finite(found, FOUND), config, in->joints, in->found_guess, found, &info);
    CALL(inverse, all_finite(joints, N), config, in->found, in->guess, joints, &info);
    memcpy(found, in->found_guess, sizeof found);
    CALL(track, all_finite(found, FOUND) && isfinite(info.residual), in->joints, found, &info);
    memcpy(joints, in->guess, sizeof joints);
    CALL(track_inverse, all_finite(joints, N) && isfinite(info.residual), in->found, joints, &info);
    CALL(jacobian, all_finite(matrix, FOUND * N), in->joints, in->found, matrix);
    CALL(rates, all_finite(found, FOUND), in->joints, in->found, in->rates, found);
    CALL(torques, all_finite(joints, N), in->joints, in->found, in->found_rates, joints);
    CALL(inverse_jacobian, all_finite(matrix, FOUND * N), in->joints, in->found, matrix);
    CALL(second, all_finite(matrix, FOUND * N) && all_finite(second, FOUND * N * N), in->joints, in->found, matrix, second);
    CALL(inertia, all_finite(matrix, FOUND * N), in->joints, in->found, in->limits, matrix);
    CALL(torque_limits, all_finite(found, FOUND), in->joints, in->found, in->limits, found);
    CALL(rate_limits, all_finite(found, FOUND), in->joints, in->found, in->limits, found);
}
#else
static void call_all(const inputs *in, long number)
{
    const F(config) *const config = in->usual ? NULL : &in->config;
    real joints[N], matrix[6 * N];
    F(pose) out = in->pose;
    F(info) info;
    int function = 0;
    memset(joints, 0, sizeof joints);
    memset(matrix, 0, sizeof matrix);
    of_finite = inputs_finite(in);
#ifdef SERIAL
    CALL(direct, pose_finite(&out), in->joints, &out);
    CALL(inverse, all_finite(joints, N), config, &in->pose, in->guess, joints, &info);
    CALL(jacobian, all_finite(matrix, 6 * N), in->joints, matrix);
#ifdef HAS_track
    memcpy(joints, in->guess, sizeof joints);
    CALL(track, all_finite(joints, N) && isfinite(info.residual), &in->pose, joints, &info);
#endif
#else
    CALL(direct, pose_finite(&out), config, in->joints, &in->pose, &out, &info);
    out = in->pose;
    CALL(track, pose_finite(&out) && isfinite(info.residual), in->joints, &out, &info);
    CALL(inverse, all_finite(joints, N), &in->pose, joints);
    CALL(jacobian, all_finite(matrix, 6 * N), &in->pose, matrix);
#ifdef HAS_line
    for (int i = 0; i < 7; ++i) {
        /* to a pose of the vectors, then to itself */
        real *const place = (i < 3) ? &out.position[i] : &out.quaternion[i - 3];
        *place = F(vector_poses)[number % M(VECTORS)][i];
    }
    CALL(line, info.residual == (real)0, config, &in->pose, &out, &info);
    CALL(line, info.residual == (real)0, config, &in->pose, &in->pose, &info);
#endif
#endif
#ifdef HAS_rates
    {
        real speeds[N], twist[6], feed = (real)0;
#ifdef SERIAL
        const real *const place = in->joints;
#else
        const F(pose) *const place = &in->pose;
#endif
#ifdef SERIAL
        CALL(rates, all_finite(speeds, N) && isfinite(info.residual), place, in->twist, speeds, &info);
#else
        CALL(rates, all_finite(speeds, N), place, in->twist, speeds);
#endif
#ifdef HAS_twist
        CALL(twist, all_finite(twist, 6), place, in->rates, twist);
#endif
#ifdef HAS_feed
        CALL(feed, feed >= (real)0 && feed <= (real)1, place, in->twist, in->limits, &feed);
#endif
        (void)twist;
        (void)feed;
    }
#endif
#ifdef HAS_inverse_nearest
    CALL(inverse_nearest, all_finite(joints, N), &in->pose, in->guess, joints);
    CALL(inverse_branch, all_finite(joints, N), &in->pose, (unsigned int)(number % (M(BRANCHES) + 1)), joints);
    {
        real all[M(BRANCHES)][N];
        int count;
        begin();
        count = F(inverse_all)(FIRST &in->pose, all);
        finish();
        end(function++, "inverse_all", (count < 0 || count > M(BRANCHES)) ? -1 : (count == 0), count == 0 || all_finite(all[0], count * N), number);
    }
#endif
}

#endif
