/* Many calls of one folder's functions: HEADER, REAL and OF(name) are macros of the command line's. Platforms: goals are joint values and
 * guesses poses; arms (ARM): goals are poses and guesses joint values; maps (MAP): goals and guesses are values of either side. */
#include HEADER

#define POSE (OF(pose) *)
#define POSE_IN (const OF(pose) *)

/* Calls with a guess: numbers of a goal and of a guess, and as which type these are given. */
#define ASK(named, function, of_goal, of_guess, goal, guess, result)                                                            \
    void named(int count, const REAL *goals, const REAL *guesses, REAL *found, int *status, int *steps)                         \
    {                                                                                                                           \
        for (int k = 0; k < count; ++k, goals += of_goal, guesses += of_guess, found += of_guess) {                             \
            OF(info) info;                                                                                                      \
            status[k] = (int)OF(function)(0, goal(goals), guess(guesses), result(found), &info);                                \
            steps[k] = info.iterations;                                                                                         \
        }                                                                                                                       \
    }
#define BACK(function, of_found, of_goal, found_as, goal_as)                                                                    \
    void back_all(int count, const REAL *found, REAL *goals, int *status)                                                       \
    {                                                                                                                           \
        for (int k = 0; k < count; ++k) {                                                                                       \
            status[k] = (int)OF(function)(found_as(found + of_found * k), goal_as(goals + of_goal * k));                        \
        }                                                                                                                       \
    }

#if defined(MAP)
ASK(ask_all, direct, JOINTS, JOINTS, , , )
ASK(ask_inverse, inverse, JOINTS, JOINTS, , , )
#elif defined(ARM)
ASK(ask_all, inverse, 7, JOINTS, POSE_IN, , )
BACK(direct, JOINTS, 7, , POSE)
#else
ASK(ask_all, direct, JOINTS, 7, , POSE_IN, POSE)
BACK(inverse, 7, JOINTS, POSE_IN, )
#endif
