/* Joint values of a pose: lengths of the rod vectors, less the offsets. */
name_status name_inverse(GEOMETRY_GIVEN const name_pose *pose, name_real joints[6])
{
    name_direct_work w;
    name_status status = name_normalise_pose(GEOMETRY pose, w.x);
    IF_OK {
        name_rod_values(GEOMETRY &w);
        status = name_limit_joints(GEOMETRY status, w.k);
        IF_OK {
            @copy_joints
        }
    }
    return status;
}

/* Rows (u_i, (R a_i) x u_i), u_i the unit vector along rod i: its rate by the platform's twist. */
name_status name_jacobian(GEOMETRY_GIVEN const name_pose *pose, name_real jacobian[36])
{
    name_real x[7];
    name_status status = name_normalise_pose(GEOMETRY pose, x);
    IF_OK {
        @jacobian
        /* where a rod has no length there is no direction */
        if (!(shortest > 0.0)) {
            status = NAME_SINGULAR;
        } else {
            @store_jacobian
        }
    }
    return status;
}

