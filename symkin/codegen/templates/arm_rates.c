/* Joint rates next to a twist, damped near singularities. */
@{p}_status @{p}_rates(@{gp}const @{real} joints[@{nq}], const @{real} twist[6], @{real} rates[@{nq}], @{p}_info *info)
{
    @{real} jacobian[@{nj}];
    const @{p}_status status = @{p}_check_speeds(twist, 6, @{own_jacobian}(@{ga}joints, jacobian));
    @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
    if (status == @{P}_OK) {
        @{real} e[6];
        @{real} found[@{nq}];
@{twist_taken}
        for (int i = 0; i < 6; ++i) {
            e[i] = @{given}[i] * ((i < 3) ? @{per_size} : @{one});
        }
        const @{real} pivot = @{p}_damped(jacobian, e, found);
        /* what is missing of the twist */
        for (int i = 0; i < 6; ++i) {
            @{real} sum = @{given}[i];
            for (int j = 0; j < @{nq}; ++j) {
                sum -= jacobian[@{nq} * i + j] * found[j];
            }
            e[i] = sum * ((i < 3) ? @{per_size} : @{one});
        }
        for (int i = 0; i < @{nq}; ++i) {
            rates[i] = found[i];
        }
        @{p}_write_info(info, 1U, @{p}_length_of(e), @{zero}, (pivot > @{zero}) ? (@{one} / pivot) : @{zero});
    }
    return status;
}

/* One damped step towards a pose, shortened where the error would grow. */
@{p}_status @{p}_track(@{gp}const @{p}_pose *pose, @{real} joints[@{nq}], @{p}_info *info)
{
    static const @{real} per_turn[@{nq}] = { @{per_turns} };
    @{real} to[7];
    @{real} jacobian[@{nj}];
    @{p}_status status = @{p}_normalise_pose(@{ga}pose, to);
    const @{p}_status started = @{own_jacobian}(@{ga}joints, jacobian);
    @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
    if ((started != @{P}_OK) && (status != @{P}_NONFINITE)) {
        status = started;
        if (info != NULL) {
            info->joint = @{p}_first_beyond(@{ga}joints);
        }
    }
    if (status == @{P}_OK) {
        @{real} e[6];
        @{real} step[@{nq}];
        @{real} moved[@{nq}];
        const @{real} before = @{p}_pose_error(@{ga}joints, to, e);
        const @{real} pivot = @{p}_damped(jacobian, e, step);
        @{real} after = @{huge};
        @{real} part = @{one};
        @{real} longest = @{zero};
        @{real} size = @{zero};
        for (int i = 0; i < @{nq}; ++i) {
            const @{real} turn = @{fabs}(step[i]) * per_turn[i];
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
            after = @{p}_pose_error(@{ga}moved, to, e);
        }
        if (!(after <= before + @{rounding})) {
            /* nothing is nearer: the joints stay */
            part = @{zero};
            after = before;
            for (int i = 0; i < @{nq}; ++i) {
                moved[i] = joints[i];
            }
        }
        status = @{p}_check_limits(@{ga}moved);
        @{p}_write_info(info, 1U, after, part * part * size * @{P}_SIZE * @{P}_SIZE, (pivot > @{zero}) ? (@{one} / pivot) : @{zero});
        if (status == @{P}_OK) {
            for (int i = 0; i < @{nq}; ++i) {
                joints[i] = moved[i];
            }
        } else if (info != NULL) {
            info->joint = @{p}_first_beyond(@{ga}moved);
        } else {
            /* nobody asks which joint */
        }
    }
    return status;
}

