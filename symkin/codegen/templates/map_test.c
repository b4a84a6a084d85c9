/* Test of @{p}.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "@{p}.h"
#include "@{p}_vectors.h"

#include <math.h>
#include <stdio.h>

#define N @{P}_JOINTS

static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, case %d\n", what, number);
    }
}

static void copy(const @{p}_real from[N], @{p}_real to[N])
{
    for (int i = 0; i < N; ++i) {
        to[i] = from[i];
    }
}

/* Largest difference, that of angles times the size. */
static double difference(const @{p}_real a[N], const @{p}_real b[N], const double weight[N])
{
    double largest = 0.0;
    for (int i = 0; i < N; ++i) {
        const double off = weight[i] * fabs((double)a[i] - (double)b[i]);
        largest = (off <= largest) ? largest : off;
    }
    return largest;
}

static void solve_all(void)
{
    static const double of_joints[N] = { @{joint_weights} };
    static const double of_found[N] = { @{found_weights} };
    for (int k = 0; k < @{P}_VECTORS; ++k) {
        const double bound = @{p}_vector_bounds[k];
        @{p}_real found[N];
        @{p}_real joints[N];
        @{p}_info info;
        copy(@{p}_vector_guesses[k], found);
        expect(@{p}_direct(NULL, @{p}_vector_joints[k], found, found, &info) == @{P}_OK, "direct", k);
        expect(difference(found, @{p}_vector_found[k], of_found) <= bound, "direct's values", k);
        expect((double)info.residual <= 16.0 * bound, "direct's residual", k);
        expect(info.min_pivot > @{zero}, "direct's smallest pivot", k);
        expect(@{p}_direct(NULL, @{p}_vector_joints[k], found, found, &info) == @{P}_OK, "standing still", k);
        expect(difference(found, @{p}_vector_found[k], of_found) <= bound, "standing still's values", k);
        expect(@{p}_track(@{p}_vector_joints[k], found, &info) == @{P}_OK, "track", k);
        expect(difference(found, @{p}_vector_found[k], of_found) <= bound, "track's values", k);
        copy(@{p}_vector_joint_guesses[k], joints);
        expect(@{p}_inverse(NULL, @{p}_vector_found[k], joints, joints, &info) == @{P}_OK, "inverse", k);
        expect(difference(joints, @{p}_vector_inverse[k], of_joints) <= bound, "inverse's joints", k);
        expect(@{p}_inverse(NULL, @{p}_vector_found[k], @{p}_vector_joint_guesses[k], joints, NULL) == @{P}_OK, "inverse without info", k);
        expect(@{p}_track_inverse(@{p}_vector_found[k], joints, &info) == @{P}_OK, "track_inverse", k);
        expect(difference(joints, @{p}_vector_inverse[k], of_joints) <= bound, "track_inverse's joints", k);
    }
}

/* The Jacobian, and the law of virtual power: joint torques on joint rates do what found torques do on found rates. */
static void rates_all(void)
{
    for (int k = 0; k < @{P}_VECTOR_JACOBIANS; ++k) {
        @{p}_real jacobian[N * N];
        @{p}_real torques[N];
        @{p}_real rates[N];
        @{p}_real of_found[N];
        @{p}_real of_joints[N];
        double power = 0.0;
        double size = 1.0;
        for (int i = 0; i < N; ++i) {
            torques[i] = (@{p}_real)(1 + i);
            rates[i] = (@{p}_real)(2 - i);
        }
        expect(@{p}_jacobian(@{p}_vector_joints[k], @{p}_vector_found[k], jacobian) == @{P}_OK, "jacobian", k);
        for (int i = 0; i < N * N; ++i) {
            const double wanted = (double)@{p}_vector_jacobians[k][i];
            expect(fabs((double)jacobian[i] - wanted) <= @{jacobian_bound} * (1.0 + fabs(wanted)), "jacobian's entry", i);
        }
        expect(@{p}_rates(@{p}_vector_joints[k], @{p}_vector_found[k], rates, of_found) == @{P}_OK, "rates", k);
        expect(@{p}_torques(@{p}_vector_joints[k], @{p}_vector_found[k], torques, of_joints) == @{P}_OK, "torques", k);
        for (int i = 0; i < N; ++i) {
            power += (double)torques[i] * (double)of_found[i] - (double)of_joints[i] * (double)rates[i];
            size += fabs((double)torques[i] * (double)of_found[i]);
        }
        expect(fabs(power) <= @{jacobian_bound} * size, "power", k);
    }
}

/* Second derivatives; the inverse Jacobian against the Jacobian; that joints and found coordinates have the same kinetic energy; that a
 * found torque, and a rate, at its limit has one joint at its own, and none beyond. */
static void derivatives_all(void)
{
    for (int k = 0; k < @{P}_VECTOR_JACOBIANS; ++k) {
        const @{p}_real *const joints = @{p}_vector_joints[k];
        const @{p}_real *const found = @{p}_vector_found[k];
        @{p}_real own[N];
        @{p}_real jacobian[N * N];
        @{p}_real again[N * N];
        @{p}_real inverse[N * N];
        @{p}_real inertia[N * N];
        @{p}_real second[N * N * N];
        @{p}_real torques[N];
        @{p}_real rates[N];
        double most = 1.0;
        for (int i = 0; i < N; ++i) {
            own[i] = (@{p}_real)(1 + i);
        }
        expect(@{p}_jacobian(joints, found, jacobian) == @{P}_OK, "jacobian", k);
        expect(@{p}_inverse_jacobian(joints, found, inverse) == @{P}_OK, "inverse_jacobian", k);
        expect(@{p}_second(joints, found, NULL, second) == @{P}_OK, "second without jacobian", k);
        expect(@{p}_second(joints, found, again, second) == @{P}_OK, "second", k);
        expect(@{p}_inertia(joints, found, own, inertia) == @{P}_OK, "inertia", k);
        expect(@{p}_torque_limits(joints, found, own, torques) == @{P}_OK, "torque_limits", k);
        expect(@{p}_rate_limits(joints, found, own, rates) == @{P}_OK, "rate_limits", k);
        for (int i = 0; i < N * N * N; ++i) {
            most = fmax(most, fabs((double)@{p}_vector_seconds[k][i]));
        }
        for (int i = 0; i < N * N * N; ++i) {
            const double off = (double)second[i] - (double)@{p}_vector_seconds[k][i];
            expect(fabs(off) <= 10.0 * @{jacobian_bound} * most, "second's entry", i);
        }
        for (int i = 0; i < N; ++i) {
            double torque = 0.0;
            double rate = 0.0;
            for (int j = 0; j < N; ++j) {
                double one = 0.0;
                double energy = 0.0;
                double scale = 1.0;
                for (int l = 0; l < N; ++l) {
                    one += (double)jacobian[N * i + l] * (double)inverse[N * l + j];
                    scale += fabs((double)jacobian[N * i + l] * (double)inverse[N * l + j]);
                    for (int h = 0; h < N; ++h) {
                        energy += (double)jacobian[N * l + i] * (double)inertia[N * l + h] * (double)jacobian[N * h + j];
                        scale += fabs((double)jacobian[N * l + i] * (double)inertia[N * l + h] * (double)jacobian[N * h + j]);
                    }
                }
                expect(again[N * i + j] == jacobian[N * i + j], "second's jacobian", k);
                expect(fabs(one - ((i == j) ? 1.0 : 0.0)) <= 10.0 * @{jacobian_bound} * scale, "inverse_jacobian's entry", k);
                expect(fabs(energy - ((i == j) ? (double)own[i] : 0.0)) <= 10.0 * @{jacobian_bound} * scale, "inertia's entry", k);
                torque = fmax(torque, fabs((double)jacobian[N * i + j] * (double)torques[i]) / (double)own[j]);
                rate = fmax(rate, fabs((double)inverse[N * j + i] * (double)rates[i]) / (double)own[j]);
            }
            expect(fabs(torque - 1.0) <= @{jacobian_bound}, "torque at its limit", i);
            expect(fabs(rate - 1.0) <= @{jacobian_bound}, "rate at its limit", i);
        }
    }
}

/* Every function with one input that it refuses: the status, results untouched, info written. */
static void refuse(const @{p}_real joints[N], const @{p}_real found[N], @{p}_status wanted, int number)
{
    @{p}_real result[N];
    @{p}_real jacobian[N * N];
    @{p}_real second[N * N * N];
    @{p}_real ones[N];
    @{p}_info info;
    for (int i = 0; i < N; ++i) {
        result[i] = @{four};
        ones[i] = @{one};
    }
    info.iterations = 255U;
    expect(@{p}_direct(NULL, joints, found, result, &info) == wanted, "direct refuses", number);
    expect(info.iterations != 255U, "info written on failure", number);
    info.iterations = 255U;
    expect(@{p}_inverse(NULL, found, joints, result, &info) == wanted, "inverse refuses", number);
    expect(info.iterations != 255U, "info written on failure", number);
    for (int i = 0; i < N; ++i) {
        expect(result[i] == @{four}, "result untouched on failure", number);
    }
    expect(@{p}_jacobian(joints, found, jacobian) == wanted, "jacobian refuses", number);
    copy(found, result);
    expect(@{p}_track(joints, result, &info) == wanted, "track refuses", number);
    copy(joints, result);
    expect(@{p}_track_inverse(found, result, &info) == wanted, "track_inverse refuses", number);
    copy(joints, result);
    expect(@{p}_rates(joints, found, joints, result) == wanted, "rates refuse", number);
    expect(@{p}_torques(joints, found, joints, result) == wanted, "torques refuse", number);
    expect(@{p}_inverse_jacobian(joints, found, jacobian) == wanted, "inverse_jacobian refuses", number);
    expect(@{p}_second(joints, found, jacobian, second) == wanted, "second refuses", number);
    expect(@{p}_inertia(joints, found, ones, jacobian) == wanted, "inertia refuses", number);
    expect(@{p}_torque_limits(joints, found, ones, result) == wanted, "torque_limits refuse", number);
    expect(@{p}_rate_limits(joints, found, ones, result) == wanted, "rate_limits refuse", number);
}

static void refuse_all(void)
{
    static const @{p}_real wrong[3] = { (@{p}_real)NAN, (@{p}_real)INFINITY, -(@{p}_real)INFINITY };
    const @{p}_config none = { @{P}_TOLERANCE, 0U, @{P}_MAX_STEP };
    @{p}_real joints[N];
    @{p}_real found[N];
    @{p}_info info;
    for (int i = 0; i < N; ++i) {
        for (int k = 0; k < 4; ++k) {
            copy(@{p}_vector_joints[0], joints);
            copy(@{p}_vector_found[0], found);
            joints[i] = (k < 3) ? wrong[k] : @{far};
            refuse(joints, found, (k < 3) ? @{P}_NONFINITE : @{P}_OUT_OF_RANGE, 8 * i + k);
            copy(@{p}_vector_joints[0], joints);
            found[i] = (k < 3) ? wrong[k] : @{far};
            refuse(joints, found, (k < 3) ? @{P}_NONFINITE : @{P}_OUT_OF_RANGE, 8 * i + 4 + k);
        }
    }
    copy(@{p}_vector_joints[0], joints);
    copy(@{p}_vector_found[0], found);
    expect(@{p}_direct(&none, joints, found, found, &info) == @{P}_MAX_ITERATIONS, "direct without a step", 0);
    expect(@{p}_inverse(&none, found, joints, joints, &info) == @{P}_MAX_ITERATIONS, "inverse without a step", 0);
    for (int k = 0; k < 4; ++k) {
        /* numbers that are no inertias and no limits */
        @{p}_real matrix[N * N];
        const @{p}_status why = (k < 3) ? @{P}_NONFINITE : @{P}_OUT_OF_RANGE;
        copy(@{p}_vector_found[0], found);
        found[0] = (k < 3) ? wrong[k] : -@{one};
        expect(@{p}_inertia(joints, @{p}_vector_found[0], found, matrix) == why, "inertia refuses an inertia", k);
        expect(@{p}_torque_limits(joints, @{p}_vector_found[0], found, found) == why, "torque_limits refuse a limit", k);
        expect(@{p}_rate_limits(joints, @{p}_vector_found[0], found, found) == why, "rate_limits refuse a limit", k);
    }
}

/* Values that no configuration has, and joints and found values beyond their limits: never OK, results untouched. */
static void refuse_infeasible(void)
{
    static const struct {
        int count;
        int inverse;
        const @{p}_real (*values)[N];
    } tables[4] = {
        { @{P}_VECTOR_INFEASIBLE_JOINTS, 0, @{p}_vector_infeasible_joints },
        { @{P}_VECTOR_INFEASIBLE_FOUND, 1, @{p}_vector_infeasible_found },
        { @{P}_VECTOR_PAST_JOINTS, 2, @{p}_vector_past_joints },
        { @{P}_VECTOR_PAST_FOUND, 3, @{p}_vector_past_found }
    };
    for (int t = 0; t < 4; ++t) {
        for (int k = 0; k < tables[t].count; ++k) {
            @{p}_real result[N];
            @{p}_status status;
            for (int i = 0; i < N; ++i) {
                result[i] = @{four};
            }
            if (tables[t].inverse % 2 == 0) {
                status = @{p}_direct(NULL, tables[t].values[k], @{p}_vector_home_found, result, NULL);
            } else {
                status = @{p}_inverse(NULL, tables[t].values[k], @{p}_vector_home_joints, result, NULL);
            }
            expect((tables[t].inverse < 2) ? (status != @{P}_OK) : (status == @{P}_OUT_OF_RANGE), "values that cannot be taken", k);
            for (int i = 0; i < N; ++i) {
                expect(result[i] == @{four}, "result untouched by values that cannot be taken", k);
            }
        }
    }
}

int main(void)
{
    solve_all();
    rates_all();
    derivatives_all();
    refuse_all();
    refuse_infeasible();
    (void)printf("@{p}: %d cases, %d failures\n", @{P}_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
