/* The limb's joints for pose coordinates c, in closed form (README.md): the values of the reference's branch@within_words. */
static name_status solver_joints(const name_real c[@nc], name_real x[@count]@within)
{
    @joints_lines
}

