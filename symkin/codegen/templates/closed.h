
/* The closed form: joint values by formulas (README.md derives them), without iteration and without a guess. Each choice has two
 * solutions; a branch is a sum of the names below, 0 for the first solution of each. @{p}_inverse_all lists them in this order. */
#define @{P}_BRANCHES (@{branches})
@{flags}

/* All joint values with the given tool pose that lie within their ranges, angles about the middle of these; returns how many: 0 for
 * a pose that the arm cannot take, that is singular, or that is not finite.@{nearly} */
int @{p}_inverse_all(const @{p}_pose *pose, @{p}_real joints[@{P}_BRANCHES][@{P}_JOINTS]);

/* The joint values of one branch. @{P}_OUT_OF_RANGE where it has none, @{P}_SINGULAR where nothing decides a joint. */
@{p}_status @{p}_inverse_branch(const @{p}_pose *pose, unsigned int branch, @{p}_real joints[@{P}_JOINTS]);

/* The joint values nearest to the guess, one choice after the other, angles near the guess's. Whether the arm can move there
 * from the guess is not asked: @{p}_inverse does. Statuses as of @{p}_inverse_branch. */
@{p}_status @{p}_inverse_nearest(const @{p}_pose *pose, const @{p}_real guess[@{P}_JOINTS], @{p}_real joints[@{P}_JOINTS]);
