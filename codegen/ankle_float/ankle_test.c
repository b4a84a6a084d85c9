/* Test of ankle.c against vectors from Python. Prints what failed; exit status 0 when nothing did.
 * SPDX-License-Identifier: MIT */
#include "ankle.h"
#include "ankle_vectors.h"

#include <math.h>
#include <stdio.h>

#define N ANKLE_JOINTS

static int failures = 0;

static void expect(int right, const char *what, int number)
{
    if (!right) {
        ++failures;
        (void)printf("failed: %s, case %d\n", what, number);
    }
}

static void copy(const ankle_real from[N], ankle_real to[N])
{
    for (int i = 0; i < N; ++i) {
        to[i] = from[i];
    }
}

/* Largest difference, that of angles times the size. */
static double difference(const ankle_real a[N], const ankle_real b[N], const double weight[N])
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
    static const double of_joints[N] = { 262.01145013147806, 262.01145013147806 };
    static const double of_found[N] = { 262.01145013147806, 262.01145013147806 };
    for (int k = 0; k < ANKLE_VECTORS; ++k) {
        const double bound = ankle_vector_bounds[k];
        ankle_real found[N];
        ankle_real joints[N];
        ankle_info info;
        copy(ankle_vector_guesses[k], found);
        expect(ankle_direct(NULL, ankle_vector_joints[k], found, found, &info) == ANKLE_OK,
            "direct", k);
        expect(difference(found, ankle_vector_found[k], of_found) <= bound, "direct's values", k);
        expect((double)info.residual <= 16.0 * bound, "direct's residual", k);
        expect(info.min_pivot > 0.0f, "direct's smallest pivot", k);
        expect(ankle_direct(NULL, ankle_vector_joints[k], found, found, &info) == ANKLE_OK,
            "standing still", k);
        expect(difference(found, ankle_vector_found[k], of_found) <= bound,
            "standing still's values", k);
        expect(ankle_track(ankle_vector_joints[k], found, &info) == ANKLE_OK, "track", k);
        expect(difference(found, ankle_vector_found[k], of_found) <= bound, "track's values", k);
        copy(ankle_vector_joint_guesses[k], joints);
        expect(ankle_inverse(NULL, ankle_vector_found[k], joints, joints, &info) == ANKLE_OK,
            "inverse", k);
        expect(difference(joints, ankle_vector_inverse[k], of_joints) <= bound, "inverse's joints",
            k);
        expect(ankle_inverse(NULL, ankle_vector_found[k], ankle_vector_joint_guesses[k], joints,
            NULL) == ANKLE_OK, "inverse without info", k);
        expect(ankle_track_inverse(ankle_vector_found[k], joints, &info) == ANKLE_OK,
            "track_inverse", k);
        expect(difference(joints, ankle_vector_inverse[k], of_joints) <= bound,
            "track_inverse's joints", k);
    }
}

/* The Jacobian, and the law of virtual power: joint torques on joint rates do what found torques do
 * on found rates. */
static void rates_all(void)
{
    for (int k = 0; k < ANKLE_VECTOR_JACOBIANS; ++k) {
        ankle_real jacobian[N * N];
        ankle_real torques[N];
        ankle_real rates[N];
        ankle_real of_found[N];
        ankle_real of_joints[N];
        double power = 0.0;
        double size = 1.0;
        for (int i = 0; i < N; ++i) {
            torques[i] = (ankle_real)(1 + i);
            rates[i] = (ankle_real)(2 - i);
        }
        expect(ankle_jacobian(ankle_vector_joints[k], ankle_vector_found[k], jacobian) == ANKLE_OK,
            "jacobian", k);
        for (int i = 0; i < N * N; ++i) {
            const double wanted = (double)ankle_vector_jacobians[k][i];
            expect(fabs((double)jacobian[i] - wanted) <= 1e-4 * (1.0 + fabs(wanted)),
                "jacobian's entry", i);
        }
        expect(ankle_rates(ankle_vector_joints[k], ankle_vector_found[k], rates,
            of_found) == ANKLE_OK, "rates", k);
        expect(ankle_torques(ankle_vector_joints[k], ankle_vector_found[k], torques,
            of_joints) == ANKLE_OK, "torques", k);
        for (int i = 0; i < N; ++i) {
            power += (double)torques[i] * (double)of_found[i]
                - (double)of_joints[i] * (double)rates[i];
            size += fabs((double)torques[i] * (double)of_found[i]);
        }
        expect(fabs(power) <= 1e-4 * size, "power", k);
    }
}

/* Second derivatives; the inverse Jacobian against the Jacobian; that joints and found coordinates
 * have the same kinetic energy; that a found torque, and a rate, at its limit has one joint at its
 * own, and none beyond. */
static void derivatives_all(void)
{
    for (int k = 0; k < ANKLE_VECTOR_JACOBIANS; ++k) {
        const ankle_real *const joints = ankle_vector_joints[k];
        const ankle_real *const found = ankle_vector_found[k];
        ankle_real own[N];
        ankle_real jacobian[N * N];
        ankle_real again[N * N];
        ankle_real inverse[N * N];
        ankle_real inertia[N * N];
        ankle_real second[N * N * N];
        ankle_real torques[N];
        ankle_real rates[N];
        double most = 1.0;
        for (int i = 0; i < N; ++i) {
            own[i] = (ankle_real)(1 + i);
        }
        expect(ankle_jacobian(joints, found, jacobian) == ANKLE_OK, "jacobian", k);
        expect(ankle_inverse_jacobian(joints, found, inverse) == ANKLE_OK, "inverse_jacobian", k);
        expect(ankle_second(joints, found, NULL, second) == ANKLE_OK, "second without jacobian", k);
        expect(ankle_second(joints, found, again, second) == ANKLE_OK, "second", k);
        expect(ankle_inertia(joints, found, own, inertia) == ANKLE_OK, "inertia", k);
        expect(ankle_torque_limits(joints, found, own, torques) == ANKLE_OK, "torque_limits", k);
        expect(ankle_rate_limits(joints, found, own, rates) == ANKLE_OK, "rate_limits", k);
        for (int i = 0; i < N * N * N; ++i) {
            most = fmax(most, fabs((double)ankle_vector_seconds[k][i]));
        }
        for (int i = 0; i < N * N * N; ++i) {
            const double off = (double)second[i] - (double)ankle_vector_seconds[k][i];
            expect(fabs(off) <= 10.0 * 1e-4 * most, "second's entry", i);
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
                        energy += (double)jacobian[N * l + i] * (double)inertia[N * l
                            + h] * (double)jacobian[N * h + j];
                        scale += fabs((double)jacobian[N * l + i] * (double)inertia[N * l
                            + h] * (double)jacobian[N * h + j]);
                    }
                }
                expect(again[N * i + j] == jacobian[N * i + j], "second's jacobian", k);
                expect(fabs(one - ((i == j) ? 1.0 : 0.0)) <= 10.0 * 1e-4 * scale,
                    "inverse_jacobian's entry", k);
                expect(fabs(energy - ((i == j) ? (double)own[i] : 0.0)) <= 10.0 * 1e-4 * scale,
                    "inertia's entry", k);
                torque = fmax(torque, fabs((double)jacobian[N * i
                    + j] * (double)torques[i]) / (double)own[j]);
                rate = fmax(rate, fabs((double)inverse[N * j
                    + i] * (double)rates[i]) / (double)own[j]);
            }
            expect(fabs(torque - 1.0) <= 1e-4, "torque at its limit", i);
            expect(fabs(rate - 1.0) <= 1e-4, "rate at its limit", i);
        }
    }
}

/* Every function with one input that it refuses: the status, results untouched, info written. */
static void refuse(const ankle_real joints[N], const ankle_real found[N], ankle_status wanted,
    int number)
{
    ankle_real result[N];
    ankle_real jacobian[N * N];
    ankle_real second[N * N * N];
    ankle_real ones[N];
    ankle_info info;
    for (int i = 0; i < N; ++i) {
        result[i] = 4.0f;
        ones[i] = 1.0f;
    }
    info.iterations = 255U;
    expect(ankle_direct(NULL, joints, found, result, &info) == wanted, "direct refuses", number);
    expect(info.iterations != 255U, "info written on failure", number);
    info.iterations = 255U;
    expect(ankle_inverse(NULL, found, joints, result, &info) == wanted, "inverse refuses", number);
    expect(info.iterations != 255U, "info written on failure", number);
    for (int i = 0; i < N; ++i) {
        expect(result[i] == 4.0f, "result untouched on failure", number);
    }
    expect(ankle_jacobian(joints, found, jacobian) == wanted, "jacobian refuses", number);
    copy(found, result);
    expect(ankle_track(joints, result, &info) == wanted, "track refuses", number);
    copy(joints, result);
    expect(ankle_track_inverse(found, result, &info) == wanted, "track_inverse refuses", number);
    copy(joints, result);
    expect(ankle_rates(joints, found, joints, result) == wanted, "rates refuse", number);
    expect(ankle_torques(joints, found, joints, result) == wanted, "torques refuse", number);
    expect(ankle_inverse_jacobian(joints, found, jacobian) == wanted, "inverse_jacobian refuses",
        number);
    expect(ankle_second(joints, found, jacobian, second) == wanted, "second refuses", number);
    expect(ankle_inertia(joints, found, ones, jacobian) == wanted, "inertia refuses", number);
    expect(ankle_torque_limits(joints, found, ones, result) == wanted, "torque_limits refuse",
        number);
    expect(ankle_rate_limits(joints, found, ones, result) == wanted, "rate_limits refuse", number);
}

static void refuse_all(void)
{
    static const ankle_real wrong[3] = { (ankle_real)NAN, (ankle_real)INFINITY,
        -(ankle_real)INFINITY };
    const ankle_config none = { ANKLE_TOLERANCE, 0U, ANKLE_MAX_STEP };
    ankle_real joints[N];
    ankle_real found[N];
    ankle_info info;
    for (int i = 0; i < N; ++i) {
        for (int k = 0; k < 4; ++k) {
            copy(ankle_vector_joints[0], joints);
            copy(ankle_vector_found[0], found);
            joints[i] = (k < 3) ? wrong[k] : 2.6201145e+06f;
            refuse(joints, found, (k < 3) ? ANKLE_NONFINITE : ANKLE_OUT_OF_RANGE, 8 * i + k);
            copy(ankle_vector_joints[0], joints);
            found[i] = (k < 3) ? wrong[k] : 2.6201145e+06f;
            refuse(joints, found, (k < 3) ? ANKLE_NONFINITE : ANKLE_OUT_OF_RANGE, 8 * i + 4 + k);
        }
    }
    copy(ankle_vector_joints[0], joints);
    copy(ankle_vector_found[0], found);
    expect(ankle_direct(&none, joints, found, found, &info) == ANKLE_MAX_ITERATIONS,
        "direct without a step", 0);
    expect(ankle_inverse(&none, found, joints, joints, &info) == ANKLE_MAX_ITERATIONS,
        "inverse without a step", 0);
    for (int k = 0; k < 4; ++k) {
        /* numbers that are no inertias and no limits */
        ankle_real matrix[N * N];
        const ankle_status why = (k < 3) ? ANKLE_NONFINITE : ANKLE_OUT_OF_RANGE;
        copy(ankle_vector_found[0], found);
        found[0] = (k < 3) ? wrong[k] : -1.0f;
        expect(ankle_inertia(joints, ankle_vector_found[0], found, matrix) == why,
            "inertia refuses an inertia", k);
        expect(ankle_torque_limits(joints, ankle_vector_found[0], found, found) == why,
            "torque_limits refuse a limit", k);
        expect(ankle_rate_limits(joints, ankle_vector_found[0], found, found) == why,
            "rate_limits refuse a limit", k);
    }
}

/* Values that no configuration has, and joints and found values beyond their limits: never OK,
 * results untouched. */
static void refuse_infeasible(void)
{
    static const struct {
        int count;
        int inverse;
        const ankle_real (*values)[N];
    } tables[4] = {
        { ANKLE_VECTOR_INFEASIBLE_JOINTS, 0, ankle_vector_infeasible_joints },
        { ANKLE_VECTOR_INFEASIBLE_FOUND, 1, ankle_vector_infeasible_found },
        { ANKLE_VECTOR_PAST_JOINTS, 2, ankle_vector_past_joints },
        { ANKLE_VECTOR_PAST_FOUND, 3, ankle_vector_past_found }
    };
    for (int t = 0; t < 4; ++t) {
        for (int k = 0; k < tables[t].count; ++k) {
            ankle_real result[N];
            ankle_status status;
            for (int i = 0; i < N; ++i) {
                result[i] = 4.0f;
            }
            if (tables[t].inverse % 2 == 0) {
                status = ankle_direct(NULL, tables[t].values[k], ankle_vector_home_found, result,
                    NULL);
            } else {
                status = ankle_inverse(NULL, tables[t].values[k], ankle_vector_home_joints, result,
                    NULL);
            }
            expect((tables[t].inverse < 2) ? (status != ANKLE_OK) : (status == ANKLE_OUT_OF_RANGE),
                "values that cannot be taken", k);
            for (int i = 0; i < N; ++i) {
                expect(result[i] == 4.0f, "result untouched by values that cannot be taken", k);
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
    (void)printf("ankle: %d cases, %d failures\n", ANKLE_VECTORS, failures);
    return (failures == 0) ? 0 : 1;
}
