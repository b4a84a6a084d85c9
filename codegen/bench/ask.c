/* Many calls of one folder's functions: HEADER, REAL and OF(name) are macros of the command line's. Platforms: goals are joint values and
 * guesses poses; arms (ARM): goals are poses and guesses joint values; maps (MAP): goals and guesses are values of either side. */
#include HEADER

#define NAMED(name) OF(name)


#if defined(MAP)
void ask_all(int count, const REAL *goals, const REAL *guesses, REAL *found, int *status, int *steps)
{
    for (int k = 0; k < count; ++k) {
        NAMED(info) info;
        status[k] = (int)NAMED(direct)(0, goals + JOINTS * k, guesses + JOINTS * k, found + JOINTS * k, &info);
        steps[k] = info.iterations;
    }
}

void ask_inverse(int count, const REAL *goals, const REAL *guesses, REAL *joints, int *status, int *steps)
{
    for (int k = 0; k < count; ++k) {
        NAMED(info) info;
        status[k] = (int)NAMED(inverse)(0, goals + JOINTS * k, guesses + JOINTS * k, joints + JOINTS * k, &info);
        steps[k] = info.iterations;
    }
}
#elif defined(ARM)
void ask_all(int count, const REAL *goals, const REAL *guesses, REAL *found, int *status, int *steps)
{
    for (int k = 0; k < count; ++k) {
        NAMED(info) info;
        const NAMED(pose) *pose = (const NAMED(pose) *)(goals + 7 * k);
        status[k] = (int)NAMED(inverse)(0, pose, guesses + JOINTS * k, found + JOINTS * k, &info);
        steps[k] = info.iterations;
    }
}

void back_all(int count, const REAL *found, REAL *goals, int *status)
{
    for (int k = 0; k < count; ++k) {
        status[k] = (int)NAMED(direct)(found + JOINTS * k, (NAMED(pose) *)(goals + 7 * k));
    }
}
#else
void ask_all(int count, const REAL *goals, const REAL *guesses, REAL *found, int *status, int *steps)
{
    for (int k = 0; k < count; ++k) {
        NAMED(info) info;
        const NAMED(pose) *guess = (const NAMED(pose) *)(guesses + 7 * k);
        status[k] = (int)NAMED(direct)(0, goals + JOINTS * k, guess, (NAMED(pose) *)(found + 7 * k), &info);
        steps[k] = info.iterations;
    }
}

void back_all(int count, const REAL *found, REAL *goals, int *status)
{
    for (int k = 0; k < count; ++k) {
        status[k] = (int)NAMED(inverse)((const NAMED(pose) *)(found + 7 * k), goals + JOINTS * k);
    }
}
#endif
