/* Joint rates next to a twist, damped near singularities. */
name_status name_rates(@{gp}const name_real joints[@{nq}], const name_real twist[6], name_real rates[@{nq}], name_info *info)
{
    name_real jacobian[@{nj}];
    const name_status status = name_check_sizes(twist, 6, -@{largest}, @{own_jacobian}(@{ga}joints, jacobian));
    name_write_info(info, 0U, @{huge}, @{zero}, @{zero});
    if (status == NAME_OK) {
        name_real e[6];
        name_real found[@{nq}];
@{twist_taken}
        for (int i = 0; i < 6; ++i) {
            e[i] = @{given}[i] * ((i < 3) ? @{per_size} : @{one});
        }
        const name_real pivot = name_damped(jacobian, e, found);
        /* what is missing of the twist */
        for (int i = 0; i < 6; ++i) {
            name_real sum = @{given}[i];
            for (int j = 0; j < @{nq}; ++j) {
                sum -= jacobian[@{nq} * i + j] * found[j];
            }
            e[i] = sum * ((i < 3) ? @{per_size} : @{one});
        }
        for (int i = 0; i < @{nq}; ++i) {
            rates[i] = found[i];
        }
        name_write_info(info, 1U, name_length_of(e), @{zero}, (pivot > @{zero}) ? (@{one} / pivot) : @{zero});
    }
    return status;
}

/* One damped step towards a pose, shortened where the error would grow. */
name_status name_track(@{gp}const name_pose *pose, name_real joints[@{nq}], name_info *info)
{
    static const name_real per_turn[@{nq}] = { @{per_turns} };
    name_real to[7];
    name_real jacobian[@{nj}];
    @{work_u}
    name_status status = name_normalise_pose(@{ga}pose, to);
    const name_status started = name_limit_joints(@{ga}NAME_OK, joints);
    name_write_info(info, 0U, @{huge}, @{zero}, @{zero});
    if ((started != NAME_OK) && (status != NAME_NONFINITE)) {
        status = started;
        if (info != NULL) {
            info->joint = name_first_beyond(@{ga}joints);
        }
    }
    if (status == NAME_OK) {
        name_real e[6];
        name_real step[@{nq}];
        name_real moved[@{nq}];
        @{set_u}
        name_jacobian_at(@{ga}@{u}, jacobian);
        const name_real before = name_error_at(@{ga}@{u}, to, e);
        const name_real pivot = name_damped(jacobian, e, step);
        name_real after = @{huge};
        name_real part = @{one};
        name_real longest = @{zero};
        name_real size = @{zero};
        for (int i = 0; i < @{nq}; ++i) {
            const name_real turn = @{fabs}(step[i]) * per_turn[i];
            longest = (turn > longest) ? turn : longest;
            size += turn * turn;
        }
        if (longest > @{most_turn_literal}) {
            part = @{most_turn_literal} / longest;
        }
        for (int round = 0; (round < @{rounds}) && !(after <= before + @{rounding}); ++round) {
            part *= (round == 0) ? @{one} : @{quarter_part};
            for (int i = 0; i < @{nq}; ++i) {
                moved[i] = joints[i] + part * step[i];
            }
            @{set_moved}
            after = name_error_at(@{ga}@{u_moved}, to, e);
        }
        if (!(after <= before + @{rounding})) {
            /* nothing is nearer: the joints stay */
            part = @{zero};
            after = before;
            for (int i = 0; i < @{nq}; ++i) {
                moved[i] = joints[i];
            }
        }
        status = name_limit_joints(@{ga}status, moved);
        name_write_info(info, 1U, after, part * part * size * NAME_SIZE * NAME_SIZE, (pivot > @{zero}) ? (@{one} / pivot) : @{zero});
        if (status == NAME_OK) {
            for (int i = 0; i < @{nq}; ++i) {
                joints[i] = moved[i];
            }
        } else if (info != NULL) {
            info->joint = name_first_beyond(@{ga}moved);
        } else {
            /* nobody asks which joint */
        }
    }
    return status;
}

