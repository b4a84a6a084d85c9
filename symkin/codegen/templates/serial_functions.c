/* The tool's pose, its quaternion of unit length and with w >= 0. */
name_status name_direct(GEOMETRY_GIVEN JOINTS_GIVEN, name_pose *pose)
{
    name_status status = name_limit_joints(GEOMETRY NAME_OK, joints);
    IF_OK {
        name_real x[7];
        name_forward(GEOMETRY joints, x);
        @told
        const name_real sign = (x[3] < 0.0) ? -1.0 : 1.0;
        const name_real inverse = sign / sqrt(QUATERNIONS_DOT(x, x));
        pose->position[0] = x[0];
        pose->position[1] = x[1];
        pose->position[2] = x[2];
        pose->quaternion[0] = x[3] * inverse;
        pose->quaternion[1] = x[4] * inverse;
        pose->quaternion[2] = x[5] * inverse;
        pose->quaternion[3] = x[6] * inverse;
    }
    return status;
}

/* @how along the line of tool poses from the guess's to the given one. */
name_status name_inverse(GEOMETRY_GIVEN const name_config *config, const name_pose *pose, const name_real guess[@nq], name_real joints[@nq], name_info *info)
{
    USUAL_CONFIG
    @work
    name_real to[7];
    name_status status = name_check_finite(guess, @nq, name_normalise_pose(GEOMETRY pose, to));
    NO_INFO
    for (int i = @last_joint; i >= 0; --i) {
        if (!(fabs(guess[i]) <= @farthest_joint)) {
            status = (status == NAME_OK) ? NAME_OUT_OF_RANGE : status;
            BLAME((uint8_t)i)
        }
    }
    CHECK_CONFIG
    IF_OK {
        @to_x
        @solve
        @within
        @stand
        IF_OK {
            @out
        }
    }
    return status;
}

/* Twist of the tool by joint rates, from the derivative of the tool's pose@in_own. */
static NAME_SHARED void name_jacobian_at(GEOMETRY_GIVEN const name_real @u[@n_u], name_real jacobian[@nj])
{
@use
    @jacobian
}

@static_own name_status @own_jacobian(GEOMETRY_GIVEN JOINTS_GIVEN, name_real jacobian[@nj])
{
    @work_u
    name_status status = name_limit_joints(GEOMETRY NAME_OK, joints);
    IF_OK {
        @set_u
        name_jacobian_at(GEOMETRY @u, jacobian);
    }
    return status;
}
