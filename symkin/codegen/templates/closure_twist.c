/* The twist of joint rates: the closure's linear system at the pose. */
@static_own name_status @twist(GEOMETRY_GIVEN const name_pose *pose, const name_real rates[@nq], name_real twist[6])
{
    OWN_WORK
    LIMB_VALUES
    name_status status = name_pose_coordinates(GEOMETRY pose, c);
    IF_OK {
        status = (name_solve_limbs(GEOMETRY c, @into, passive@feasible) == NAME_OK) ? NAME_OK : NAME_OUT_OF_RANGE;
    }
    status = name_check_sizes(rates, @nq, -@largest, status);
    IF_OK {
        @state
        if (@singular_there) {
            status = NAME_SINGULAR;
        } else {
            @sides
            name_real s[@nf];
            solver_solve(w, s);
            status = name_check_finite(s, @nf, NAME_OK);
            IF_OK {
                @store
            }
        }
    }
    return status;
}

