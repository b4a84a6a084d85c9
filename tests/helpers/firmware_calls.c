/* Calls every function of a generated folder with inputs that are wrong, and says what should not have been answered.
 *
 * Macros: NAME, UPPER (the mechanism's name), HEADER, VECTORS (files to include), SERIAL or PARALLEL, STRUCT where the geometry is
 * given with each call, HUGE_FINITE (a number whose square overflows). Each number of good inputs is replaced by bad ones in turn. */
#include HEADER
#include VECTORS
#include <math.h>
#include <stdio.h>
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
#define POSE N /* where the pose begins among the inputs, and the guess of an arm */
#define GUESS (N + 7)
#define COUNT (2 * N + 7)

typedef F(real) real;

static int all_finite(const real *v, int n)
{
    for (int i = 0; i < n; ++i) {
        if (!isfinite(v[i])) {
            return 0;
        }
    }
    return 1;
}

static int pose_finite(const F(pose) * pose)
{
    return all_finite(pose->position, 3) && all_finite(pose->quaternion, 4);
}

/* The statuses of all functions; -1 where OK comes with a number that is not finite. */
static void call_all(const real in[COUNT], int status[4])
{
    real joints[N];
    real matrix[6 * N];
    F(pose) pose;
    F(pose) out;
    F(info) info;
    for (int i = 0; i < 3; ++i) {
        pose.position[i] = in[POSE + i];
    }
    for (int i = 0; i < 4; ++i) {
        pose.quaternion[i] = in[POSE + 3 + i];
    }
    out = pose;
    memset(joints, 0, sizeof joints);
    memset(matrix, 0, sizeof matrix);
#ifdef SERIAL
    status[0] = (int)F(direct)(FIRST in, &out);
    status[0] = ((status[0] == 0) && !pose_finite(&out)) ? -1 : status[0];
    status[1] = (int)F(inverse)(FIRST NULL, &pose, in + GUESS, joints, &info);
    status[1] = ((status[1] == 0) && !all_finite(joints, N)) ? -1 : status[1];
    status[2] = (int)F(jacobian)(FIRST in, matrix);
    status[2] = ((status[2] == 0) && !all_finite(matrix, 6 * N)) ? -1 : status[2];
    memcpy(joints, in + GUESS, sizeof joints);
    status[3] = (int)F(track)(FIRST &pose, joints, &info);
    status[3] = ((status[3] == 0) && !(all_finite(joints, N) && isfinite(info.residual))) ? -1 : status[3];
#else
    status[0] = (int)F(direct)(FIRST NULL, in, &pose, &out, &info);
    status[0] = ((status[0] == 0) && !pose_finite(&out)) ? -1 : status[0];
    out = pose;
    status[1] = (int)F(track)(FIRST in, &out, &info);
    status[1] = ((status[1] == 0) && !(pose_finite(&out) && isfinite(info.residual))) ? -1 : status[1];
    status[2] = (int)F(inverse)(FIRST &pose, joints);
    status[2] = ((status[2] == 0) && !all_finite(joints, N)) ? -1 : status[2];
    status[3] = (int)F(jacobian)(FIRST &pose, matrix);
    status[3] = ((status[3] == 0) && !all_finite(matrix, 6 * N)) ? -1 : status[3];
#endif
}

/* Whether a function reads a number of the inputs. */
static int reads(int function, int slot)
{
    const int of_joints = slot < N;
#ifdef SERIAL
    return ((function == 1) || (function == 3)) ? !of_joints : of_joints;
#else
    return (slot < GUESS) && ((function < 2) || !of_joints);
#endif
}

int main(void)
{
    const real bad[5] = { (real)NAN, (real)INFINITY, -(real)INFINITY, (real)HUGE_FINITE, (real)1e20 };
    int failures = 0;
    for (int case_ = 0; case_ < 2 * 5 * COUNT; ++case_) {
        const int others_wrong = case_ % 2, b = case_ / 2 % 5, slot = case_ / 10;
        real in[COUNT];
        int status[4];
        for (int i = 0; i < COUNT; ++i) {
            in[i] = (real)(others_wrong ? 9e9 : 0.0);
        }
        for (int i = 0; (i < N) && !others_wrong; ++i) {
            in[i] = F(vector_joints)[0][i];
#ifdef SERIAL
            in[GUESS + i] = F(vector_guesses)[0][i];
#endif
        }
        for (int i = 0; (i < 7) && !others_wrong; ++i) {
            in[POSE + i] = F(vector_poses)[0][i];
        }
        in[slot] = bad[b];
        call_all(in, status);
        for (int f = 0; f < 4; ++f) {
            if (reads(f, slot) && ((b < 3) ? (status[f] != (int)M(NONFINITE)) : (status[f] <= 0))) {
                ++failures;
                (void)printf("slot %d, value %d, function %d: %d\n", slot, b, f, status[f]);
            }
        }
    }
    return (failures == 0) ? 0 : 1;
}
