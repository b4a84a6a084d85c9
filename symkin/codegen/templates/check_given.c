/* Whether joint values of limbs are the given ones, but for what the rounding of a pose makes of them at a dead centre. */
static NAME_COLD name_status name_check_near(const name_real q[@nq], const name_real given[@nq])
{
    TABLE(near, @nq, @near)
    name_status status = NAME_OK;
    EACH(i, @nq) {
        if (!(fabs(given[i] - q[i]) <= near[i])) {
            status = NAME_WRONG_BRANCH;
        }
    }
    return status;
}

/* Checks the pose of an answer, as it is written: whether the limbs there, solved as name_inverse does, have the given joint values. Else
 * a limb has passed a dead centre on the way, which is a singularity, or the line of poses from the reference does not lead
 * to this one: the pose alone would not say where the limb stands. */
static NAME_COLD name_status name_check_given(GEOMETRY_GIVEN const name_real x[@nc], const name_real given[@nq])
{
    name_real q[@nq] = { 0.0 };
    LIMB_VALUES
    name_real turned[@nq];
    name_pose pose;
    name_status status;
    name_pose_from_coordinates(GEOMETRY x, &pose);
    status = name_pose_coordinates(GEOMETRY &pose, c);
    IF_OK {
        status = name_solve_limbs(GEOMETRY c, q, passive@feasible);
    }
    IF_OK {
        @within_given
        @turned_given
        status = name_check_near(q, turned);
    } else {
        status = NAME_WRONG_BRANCH;
    }
    return status;
}

