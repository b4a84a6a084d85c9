
/* Whether a pose leaves the joints that are not actuated within their limits. */
static name_status name_check_answer(const name_pose *pose)
{
    LIMB_VALUES
    name_real q[@nq] = { 0.0 };
    name_status status = name_pose_coordinates(pose, c);
    IF_OK {
        status = name_solve_limbs(c, q, passive@of_answer);
    }
    IF_OK {
        status = name_check_passive(c, q, passive);
    }
    return status;
}
