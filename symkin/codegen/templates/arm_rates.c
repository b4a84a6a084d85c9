/* Joint rates next to a twist, damped near singularities. */
name_status name_rates(GEOMETRY_GIVEN const name_real joints[@nq], const name_real twist[6], name_real rates[@nq], name_info *info)
{
    name_real jacobian[@nj];
    const name_status status = name_check_sizes(twist, 6, -@largest, @own_jacobian(GEOMETRY joints, jacobian));
    name_write_info(info, 0U, HUGE_VAL, 0.0, 0.0);
    if (status == NAME_OK) {
        name_real e[6];
        name_real found[@nq];
        @twist_taken
        for (int i = 0; i < 6; ++i) {
            e[i] = @given[i] * ((i < 3) ? @per_size : 1.0);
        }
        const name_real pivot = name_damped(jacobian, e, found);
        /* what is missing of the twist */
        for (int i = 0; i < 6; ++i) {
            name_real sum = @given[i];
            for (int j = 0; j < @nq; ++j) {
                sum -= jacobian[@nq * i + j] * found[j];
            }
            e[i] = sum * ((i < 3) ? @per_size : 1.0);
        }
        for (int i = 0; i < @nq; ++i) {
            rates[i] = found[i];
        }
        name_write_info(info, 1U, name_length_of(e), 0.0, (pivot > 0.0) ? (1.0 / pivot) : 0.0);
    }
    return status;
}

/* One damped step towards a pose, shortened where the error would grow. */
name_status name_track(GEOMETRY_GIVEN const name_pose *pose, name_real joints[@nq], name_info *info)
{
    static const name_real per_turn[@nq] = { @per_turns };
    name_real to[7];
    name_real jacobian[@nj];
    @work_u
    name_status status = name_normalise_pose(GEOMETRY pose, to);
    const name_status started = name_limit_joints(GEOMETRY NAME_OK, joints);
    name_write_info(info, 0U, HUGE_VAL, 0.0, 0.0);
    if ((started != NAME_OK) && (status != NAME_NONFINITE)) {
        status = started;
        if (info != NULL) {
            info->joint = name_first_beyond(GEOMETRY joints);
        }
    }
    if (status == NAME_OK) {
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
        for (int i = 0; i < @nq; ++i) {
            const name_real turn = fabs(step[i]) * per_turn[i];
            longest = (turn > longest) ? turn : longest;
            size += turn * turn;
        }
        if (longest > @most_turn_literal) {
            part = @most_turn_literal / longest;
        }
        for (int round = 0; (round < @rounds) && !(after <= before + @rounding); ++round) {
            part *= (round == 0) ? 1.0 : 0.25;
            for (int i = 0; i < @nq; ++i) {
                moved[i] = joints[i] + part * step[i];
            }
            @set_moved
            after = name_error_at(GEOMETRY @u_moved, to, e);
        }
        if (!(after <= before + @rounding)) {
            /* nothing is nearer: the joints stay */
            part = 0.0;
            after = before;
            for (int i = 0; i < @nq; ++i) {
                moved[i] = joints[i];
            }
        }
        status = name_limit_joints(GEOMETRY status, moved);
        name_write_info(info, 1U, after, part * part * size * NAME_SIZE * NAME_SIZE, (pivot > 0.0) ? (1.0 / pivot) : 0.0);
        if (status == NAME_OK) {
            for (int i = 0; i < @nq; ++i) {
                joints[i] = moved[i];
            }
        } else if (info != NULL) {
            info->joint = name_first_beyond(GEOMETRY moved);
        } else {
            /* nobody asks which joint */
        }
    }
    return status;
}

