/* Whether the @{values} lead from the reference configuration to the guess, which then has nowhere to go, though the @{out} alone lead
 * elsewhere: sets the numbers y of a configuration on this way, where its known values are, and the @{out} to which they lead. */
static @{COLD} bool @{f}_stands(const @{real} @{values}[@{nto}], const @{real} guess[@{nout}], @{real} y[@{ny}], @{real} at[@{nto}],
    @{real} other[@{nout}])
{
    if (@{p}_state_of_@{values}(@{values}, y, other) != @{P}_OK) {
        return false;
    }
@{stand_at}
    return @{p}_@{out}_away2(other, guess) <= @{stands2};
}

/* The @{out} at the end of the line from a configuration, with the numbers y and the known values `at`, to the given ones. */
static @{SHARED} @{p}_status @{f}_line(@{k}_work *w, const @{real} @{values}[@{nto}], const @{real} y[@{ny}], const @{real} at[@{nto}],
    const @{real} guess[@{nout}], @{real} result[@{nout}], const @{p}_config *config, @{p}_info *info)
{
    @{p}_status status;
@{begin}
@{follow}
    if (status == @{P}_OK) {
@{line_results}
    }
    return status;
}

/* Whether a configuration has the given values but for rounding, and with which residual: sets the state to it. */
static @{SHARED} bool @{f}_closes(@{k}_work *w, const @{real} @{values}[@{nto}], const @{real} @{from}[@{nfrom}],
    const @{p}_config *config, @{real} *residual)
{
    @{k}_place(w, @{values}, @{from});
    @{k}_rows(w);
    *residual = @{k}_residual(w);
    return *residual <= config->tolerance + @{reading};
}

/* Whether an answer can be held: read as a guess it has the given values, or leads to itself. */
static @{SHARED} bool @{f}_holds(@{k}_work *w, const @{real} @{values}[@{nto}], const @{real} answer[@{nout}], const @{p}_config *config)
{
    @{real} y[@{ny}];
    @{real} at[@{nto}];
    @{real} again[@{nout}];
    @{real} residual;
    if (@{p}_state_of_@{out}(answer, y, at) != @{P}_OK) {
        return false;
    }
    return @{f}_closes(w, @{values}, @{answer_from}, config, &residual)
        || ((@{f}_line(w, @{values}, y, at, answer, again, config, NULL) == @{P}_OK)
            && (@{p}_@{out}_away2(again, answer) <= @{same2}));
}

/* @{about} */
@{p}_status @{f}(const @{p}_config *config, const @{real} @{values}[@{nto}], const @{real} guess[@{nout}], @{real} @{out}[@{nout}],
    @{p}_info *info)
{
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
    const @{p}_config *const used = (config != NULL) ? config : &usual;
    @{k}_work w;
    @{real} y[@{ny}];
    @{real} at[@{nto}];
    @{real} result[@{nout}];
    @{real} other[@{nout}];
    @{p}_status status = @{p}_limit_@{values}(@{P}_OK, @{values});
    status = @{p}_bound_@{out}(status, guess);
    if (config != NULL) {
        status = @{p}_check_config(config, status);
    }
    const bool asked = (status == @{P}_OK);
    if (asked) {
        status = @{p}_state_of_@{out}(guess, y, at);
    }
    if (status != @{P}_OK) {
        @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
@{blame_values}
    } else {
        @{real} residual;
        const bool still = @{f}_closes(&w, @{values}, @{guess_from}, used, &residual);
        status = @{f}_line(&w, @{values}, y, at, guess, result, used, info);
        /* of a guess that has the values the answer is near */
        if ((status == @{P}_OK) && !(@{f}_holds(&w, @{values}, result, used)
            && (!still || (@{p}_@{out}_away2(result, guess) <= @{held2})))) {
            status = @{P}_WRONG_BRANCH;
        }
        if (still && (status == @{P}_WRONG_BRANCH)) {
            /* the guess itself is an answer */
            status = @{P}_OK;
            @{k}_place(&w, @{values}, @{guess_from});
            for (int i = 0; i < @{nout}; ++i) {
                result[i] = guess[i];
            }
            @{p}_write_info(info, 0U, residual, @{zero}, @{zero});
        }
    }
    if (asked && (status != @{P}_OK) && @{f}_stands(@{values}, guess, y, at, other)) {
        status = @{f}_line(&w, @{values}, y, at, guess, result, used, info);
        if ((status == @{P}_OK) && (@{p}_@{out}_away2(other, result) > @{stands2})) {
            status = @{P}_WRONG_BRANCH;
        }
    }
    if (status == @{P}_OK) {
        status = @{p}_limit_@{out}(status, result);
@{passive}
        if (status == @{P}_OK) {
@{store}
        }
@{blame_result}
    }
    return status;
}

/* @{about_track} */
@{p}_status @{track}(const @{real} @{values}[@{nto}], @{real} @{out}[@{nout}], @{p}_info *info)
{
    @{k}_work w;
@{y}
    @{p}_status status = @{p}_limit_@{values}(@{P}_OK, @{values});
    status = @{p}_bound_@{out}(status, @{out});
@{last}
    if (status == @{P}_OK) {
@{step}
    } else {
        @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
@{blame_values}
    }
    if (status == @{P}_OK) {
@{track_results}
        @{real} change2 = @{zero};
@{change}
        /* beyond a small step the branch is not assured */
        status = (change2 <= @{track2}) ? @{P}_OK : @{P}_WRONG_BRANCH;
        status = @{p}_limit_@{out}(status, result);
@{passive}
        if (status == @{P}_OK) {
@{store}
        }
@{blame_result}
    }
    return status;
}

