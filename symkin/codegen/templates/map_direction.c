/* Whether the @{values} lead from the reference configuration to the guess, which then has nowhere to go, though the @{out} alone lead
 * elsewhere: sets the numbers y of a configuration on this way, and where its known values are. */
static @{COLD} bool @{f}_stands(const @{real} @{values}[@{nto}], const @{real} guess[@{nout}], @{real} y[@{ny}], @{real} at[@{nto}])
{
    @{real} other[@{nout}];
    @{real} away2 = @{zero};
    if (@{p}_state_of_@{values}(@{values}, y, other) != @{P}_OK) {
        return false;
    }
@{away}
@{stand_at}
    return away2 <= @{stands2};
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
    @{p}_status status = @{p}_limit_@{values}(@{P}_OK, @{values});
    status = @{p}_bound_@{out}(status, guess);
    if (config != NULL) {
        status = @{p}_check_config(config, status);
    }
    bool asked = (status == @{P}_OK);
    if (asked) {
        status = @{p}_state_of_@{out}(guess, y, at);
    }
    if (status != @{P}_OK) {
        @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
@{blame_values}
    }
    const bool told = (status == @{P}_OK);
    bool goes = told;
    for (int way = 0; way < 2; ++way) {
        if (goes) {
            /* the line begins where the known values are at the guess */
@{begin}
@{follow}
        }
        goes = asked && (status != @{P}_OK) && @{f}_stands(@{values}, guess, y, at);
        asked = false;
    }
    if (status == @{P}_OK) {
@{results}
        status = @{p}_limit_@{out}(status, result);
        /* what these values alone do not tell could not be left again: there one may but stay */
        if ((status == @{P}_OK) && told && (@{p}_state_of_@{out}(result, y, at) != @{P}_OK)
            && !@{f}_stands(@{values}, guess, y, at)) {
            status = @{P}_WRONG_BRANCH;
        }
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

