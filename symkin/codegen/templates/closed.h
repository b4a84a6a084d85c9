/* The closed form: joint values by formulas (README.md derives them), without iteration and without a guess. Each choice has two solutions; a branch is a sum of the names below, 0 for the first solution of each. name_inverse_all lists them in this order. */
#define NAME_BRANCHES (@branches)
@flags

/* All joint values with the given tool pose that lie within their ranges, angles about the middle of these; returns how many: 0 for a pose that the arm cannot take, that is singular, or that is not finite. A branch at which the arm is singular but for rounding is left out.@{nearly} */
int name_inverse_all(const name_pose *pose, name_real joints[NAME_BRANCHES][NAME_JOINTS]);