/* Joint values of a pose, limb by limb. */
name_status name_inverse(GEOMETRY_GIVEN const name_pose *pose, name_real joints[@nq])
{
    LIMB_VALUES
    name_real q[@nq] = { 0.0 };
    name_status status = name_pose_coordinates(GEOMETRY pose, c);
    IF_OK {
        status = name_solve_limbs(GEOMETRY c, q, passive@feasible);
        if (status != NAME_OK) {
            status = NAME_OUT_OF_RANGE;
        } else {
            @within_middle
            status = name_limit_joints(GEOMETRY status, q);
        }
        @inverse_passive
        IF_OK {
            @copy_joints
        }
    }
    return status;
}

/* Joint rates by the platform's twist, limb by limb: each limb's matrix solved for its right-hand sides. */
@static_own name_status @jacobian(GEOMETRY_GIVEN const name_pose *pose, name_real rates[@nq * 6])
{
    name_real c[@nc];
    name_real jacobian[@nq * 6] = { 0.0 };
    name_status status = name_pose_coordinates(GEOMETRY pose, c);
    IF_OK {
        @rates
        if ((status == NAME_OK) && (name_check_finite(jacobian, @nq * 6, NAME_OK) != NAME_OK)) {
            status = NAME_SINGULAR;
        }
        IF_OK {
            COPY(rates, jacobian, @nq * 6)
        } else if (status != NAME_SINGULAR) {
            status = NAME_OUT_OF_RANGE;
        } else {
            /* singular */
        }
    }
    return status;
}
