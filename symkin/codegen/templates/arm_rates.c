/* Joint rates y (of slides over the size) of least |J y - e| and length, J and e in angles and lengths over the size. Solves the
 * @{nm} normal equations with exchanges on the diagonal; where their smallest pivot is below @{damped_pivot} of the mean, the
 * diagonal is raised, the more the smaller it is. Returns that pivot over the mean. */
static @{real} @{p}_damped(const @{real} jacobian[@{nj}], const @{real} e[6], @{real} y[@{nq}])
{
    static const @{real} row_scale[6] = { @{row_scales} };
    static const @{real} column_scale[@{nq}] = { @{column_scales} };
    @{real} a[6][@{nq}];
    @{real} g[@{nm}][@{nm}];
    @{real} r[@{nm}];
    @{real} smallest = @{zero};
    @{real} mean = @{zero};
    @{real} raised = @{zero};
    for (int i = 0; i < 6; ++i) {
        for (int j = 0; j < @{nq}; ++j) {
            a[i][j] = jacobian[@{nq} * i + j] * row_scale[i] * column_scale[j];
            mean += a[i][j] * a[i][j] * @{per_count};
        }
    }
    for (int round = 0; (round < 2) && ((round == 0) || (smallest < @{damped_pivot})); ++round) {
        uint8_t order[@{nm}];
        /* the normal equations */
        for (int i = 0; i < @{nm}; ++i) {
            order[i] = (uint8_t)i;
            r[i] = @{right_start};
            for (int j = 0; j < @{right_count}; ++j) {
                r[i] += @{right_term};
            }
            for (int j = 0; j < @{nm}; ++j) {
                g[i][j] = (i == j) ? raised : @{zero};
                for (int k = 0; k < @{inner}; ++k) {
                    g[i][j] += @{product};
                }
            }
        }
        /* factors, the largest diagonal entry first, with the right side beside them */
        bool whole = true;
        for (int c = 0; (c < @{nm}) && whole; ++c) {
            int best = c;
            for (int i = c + 1; i < @{nm}; ++i) {
                best = (g[i][i] > g[best][best]) ? i : best;
            }
            const uint8_t name = order[c];
            const @{real} right = r[c];
            order[c] = order[best];
            order[best] = name;
            r[c] = r[best];
            r[best] = right;
            for (int j = 0; j < @{nm}; ++j) {
                const @{real} t = g[c][j];
                g[c][j] = g[best][j];
                g[best][j] = t;
            }
            for (int i = 0; i < @{nm}; ++i) {
                const @{real} t = g[i][c];
                g[i][c] = g[i][best];
                g[i][best] = t;
            }
            whole = g[c][c] > @{least_pivot} * mean;
            for (int i = c + 1; (i < @{nm}) && whole; ++i) {
                const @{real} factor = g[i][c] / g[c][c];
                for (int j = c; j < @{nm}; ++j) {
                    g[i][j] -= factor * g[c][j];
                }
                r[i] -= factor * r[c];
            }
        }
        if (round == 0) {
            smallest = whole ? (g[@{last}][@{last}] / mean) : @{zero};
            raised = mean * (@{damped_pivot} - smallest);
        }
        /* back substitution; without a whole set of factors the next round follows */
        for (int i = @{last}; (i >= 0) && whole; --i) {
            for (int j = i + 1; j < @{nm}; ++j) {
                r[i] -= g[i][j] * r[j];
            }
            r[i] /= g[i][i];
        }
        for (int i = 0; i < @{nq}; ++i) {
            y[i] = @{zero};
        }
        for (int i = 0; (i < @{nm}) && whole; ++i) {
@{back}
        }
    }
    for (int i = 0; i < @{nq}; ++i) {
        y[i] *= column_scale[i];
    }
    return smallest;
}

/* Length of a twist or of an error of poses in angles and lengths over the size, as a length. */
static @{real} @{p}_length_of(const @{real} e[6])
{
    @{real} sum = @{zero};
    for (int i = 0; i < 6; ++i) {
        sum += e[i] * e[i];
    }
    return @{sqrt}(sum) * @{P}_SIZE;
}

/* The twist of joint rates: the Jacobian times the rates. */
@{p}_status @{p}_twist(@{gp}const @{real} joints[@{nq}], const @{real} rates[@{nq}], @{real} twist[6])
{
    @{real} jacobian[@{nj}];
    @{real} found[6];
    const @{p}_status status = @{p}_check_speeds(rates, @{nq}, @{p}_jacobian(@{ga}joints, jacobian));
    if (status == @{P}_OK) {
        for (int i = 0; i < 6; ++i) {
            @{real} sum = @{zero};
            for (int j = 0; j < @{nq}; ++j) {
                sum += jacobian[@{nq} * i + j] * rates[j];
            }
            found[i] = sum;
        }
        /* rates and twist may be the same array */
        for (int i = 0; i < 6; ++i) {
            twist[i] = found[i];
        }
    }
    return status;
}

/* Joint rates next to a twist, damped near singularities. */
@{p}_status @{p}_rates(@{gp}const @{real} joints[@{nq}], const @{real} twist[6], @{real} rates[@{nq}], @{p}_info *info)
{
    @{real} jacobian[@{nj}];
    const @{p}_status status = @{p}_check_speeds(twist, 6, @{p}_jacobian(@{ga}joints, jacobian));
    @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
    if (status == @{P}_OK) {
        @{real} e[6];
        @{real} found[@{nq}];
        for (int i = 0; i < 6; ++i) {
            e[i] = twist[i] * ((i < 3) ? @{per_size} : @{one});
        }
        const @{real} pivot = @{p}_damped(jacobian, e, found);
        /* what is missing of the twist */
        for (int i = 0; i < 6; ++i) {
            @{real} sum = twist[i];
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

/* The largest factor, up to 1, by which a twist keeps all joint rates within their limits. */
@{p}_status @{p}_feed(@{gp}const @{real} joints[@{nq}], const @{real} twist[6], const @{real} rate_limits[@{nq}], @{real} *feed)
{
    @{real} rates[@{nq}];
    @{p}_status status = @{p}_check_finite(rate_limits, @{nq}, @{p}_rates(@{ga}joints, twist, rates, NULL));
    @{real} most = @{one};
    for (int i = 0; (i < @{nq}) && (status == @{P}_OK); ++i) {
        const @{real} rate = @{fabs}(rates[i]);
        if (rate_limits[i] < @{zero}) {
            status = @{P}_OUT_OF_RANGE;
        } else if (rate * most > rate_limits[i]) {
            most = rate_limits[i] / rate;
        } else {
            /* within its limit */
        }
    }
    if (status == @{P}_OK) {
        *feed = most;
    }
    return status;
}

/* How far the tool pose of joint values is from `to`: lengths over the size, and twice the vector of the turn's quaternion. Returns
 * its length. */
static @{real} @{p}_pose_error(@{gp}const @{real} q[@{nq}], const @{real} to[7], @{real} e[6])
{
    @{real} x[7];
    @{p}_forward(@{ga}q, x);
    const @{real} w = to[3] * x[3] + to[4] * x[4] + to[5] * x[5] + to[6] * x[6];
    const @{real} twice = (w < @{zero}) ? -@{two} : @{two};
    for (int i = 0; i < 3; ++i) {
        e[i] = (to[i] - x[i]) * @{per_size};
    }
    e[3] = twice * (to[4] * x[3] - to[3] * x[4] - to[5] * x[6] + to[6] * x[5]);
    e[4] = twice * (to[5] * x[3] - to[3] * x[5] - to[6] * x[4] + to[4] * x[6]);
    e[5] = twice * (to[6] * x[3] - to[3] * x[6] - to[4] * x[5] + to[5] * x[4]);
    return @{p}_length_of(e);
}

/* One damped step towards a pose, shortened where the error would grow. */
@{p}_status @{p}_track(@{gp}const @{p}_pose *pose, @{real} joints[@{nq}], @{p}_info *info)
{
    static const @{real} per_turn[@{nq}] = { @{per_turns} };
    @{real} to[7];
    @{real} jacobian[@{nj}];
    @{p}_status status = @{p}_normalise_pose(@{ga}pose, to);
    const @{p}_status started = @{p}_jacobian(@{ga}joints, jacobian);
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

