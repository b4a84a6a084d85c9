/* Joint rates next to a twist, damped near singularities. */
name_status name_rates(GEOMETRY_GIVEN JOINTS_GIVEN, const name_real twist[6], name_real rates[@nq], name_info *info)
{
    name_real jacobian[@nj];
    const name_status status = name_check_sizes(twist, 6, -@largest, @own_jacobian(GEOMETRY joints, jacobian));
    NO_INFO
    IF_OK {
        name_real e[6];
        name_real found[@nq];
        @twist_taken
        EACH(i, 6) {
            e[i] = @given[i] * ((i < 3) ? @per_size : 1.0);
        }
        const name_real pivot = name_damped(jacobian, e, found);
        /* what is missing of the twist */
        EACH(i, 6) {
            name_real sum = @given[i];
            EACH(j, @nq) {
                sum -= jacobian[@nq * i + j] * found[j];
            }
            e[i] = sum * ((i < 3) ? @per_size : 1.0);
        }
        COPY(rates, found, @nq)
        name_write_info(info, 1U, name_length_of(e), 0.0, (pivot > 0.0) ? (1.0 / pivot) : 0.0);
    }
    return status;
}

/* One damped step towards a pose, shortened where the error would grow. */
name_status name_track(GEOMETRY_GIVEN const name_pose *pose, name_real joints[@nq], name_info *info)
{
    TABLE(per_turn, @nq, @per_turns)
    name_real to[7];
    name_real jacobian[@nj];
    @work_u
    name_status status = name_normalise_pose(GEOMETRY pose, to);
    const name_status started = name_limit_joints(GEOMETRY NAME_OK, joints);
    NO_INFO
    if ((started != NAME_OK) && (status != NAME_NONFINITE)) {
        status = started;
        BLAME(name_first_beyond(GEOMETRY joints))
    }
    IF_OK {
        name_real e[6];
        name_real step[@nq];
        name_real moved[@nq];
        @set_u
        name_jacobian_at(GEOMETRY @u, jacobian);
        const name_real before = name_error_at(GEOMETRY @u, to, e);
        const name_real pivot = name_damped(jacobian, e, step);
        name_real after = HUGE_VAL;
        name_real part = 1.0;
        name_real longest = 0.0;
        name_real size = 0.0;
        EACH(i, @nq) {
            const name_real turn = fabs(step[i]) * per_turn[i];
            longest = (turn > longest) ? turn : longest;
            size += turn * turn;
        }
        if (longest > @most_turn_literal) {
            part = @most_turn_literal / longest;
        }
        EACH_WHILE(round, @rounds, !(after <= before + @rounding)) {
            part *= (round == 0) ? 1.0 : 0.25;
            EACH(i, @nq) {
                moved[i] = joints[i] + part * step[i];
            }
            @set_moved
            after = name_error_at(GEOMETRY @u_moved, to, e);
        }
        if (!(after <= before + @rounding)) {
            /* nothing is nearer: the joints stay */
            part = 0.0;
            after = before;
            COPY(moved, joints, @nq)
        }
        status = name_limit_joints(GEOMETRY status, moved);
        name_write_info(info, 1U, after, part * part * size * NAME_SIZE * NAME_SIZE, (pivot > 0.0) ? (1.0 / pivot) : 0.0);
        IF_OK {
            COPY(joints, moved, @nq)
        } else if (info != NULL) {
            info->joint = name_first_beyond(GEOMETRY moved);
        } else {
            /* nobody asks which joint */
        }
    }
    return status;
}

