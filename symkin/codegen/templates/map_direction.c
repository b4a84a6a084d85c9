/* @{about} */
@{p}_status @{f}(const @{p}_config *config, const @{real} @{values}[@{nto}], const @{real} guess[@{nout}], @{real} @{out}[@{nout}],
    @{p}_info *info)
{
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
    const @{p}_config *const used = (config != NULL) ? config : &usual;
    @{k}_work w;
    @{real} y[@{ny}];
    @{p}_status status = @{p}_check_range(@{P}_OK, @{values}, @{p}_low_@{values}, @{p}_high_@{values}, @{nto});
    status = @{p}_check_range(status, guess, @{p}_least_@{out}, @{p}_most_@{out}, @{nout});
    if (config != NULL) {
        status = @{p}_check_config(config, status);
    }
    @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
@{blame_values}    if (status == @{P}_OK) {
        status = @{p}_state_of_@{out}(guess, y);
    }
    if (status == @{P}_OK) {
        /* the line begins where the known values are at the guess */
@{begin}
@{follow}
    }
    if (status == @{P}_OK) {
@{results}
        status = @{p}_check_range(status, result, @{p}_low_@{out}, @{p}_high_@{out}, @{nout});
@{blame_result}        if (status == @{P}_OK) {
@{store}
        }
    }
    return status;
}

/* @{about_track} */
@{p}_status @{track}(const @{real} @{values}[@{nto}], @{real} @{out}[@{nout}], @{p}_info *info)
{
    @{k}_work w;
@{y}
    @{p}_status status = @{p}_check_range(@{P}_OK, @{values}, @{p}_low_@{values}, @{p}_high_@{values}, @{nto});
    status = @{p}_check_range(status, @{out}, @{p}_least_@{out}, @{p}_most_@{out}, @{nout});
    @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
@{blame_values}@{last}
    if (status == @{P}_OK) {
@{step}
    }
    if (status == @{P}_OK) {
@{track_results}
        @{real} change2 = @{zero};
@{change}
        /* beyond a small step the branch is not assured */
        status = (change2 <= @{track2}) ? @{P}_OK : @{P}_WRONG_BRANCH;
        status = @{p}_check_range(status, result, @{p}_low_@{out}, @{p}_high_@{out}, @{nout});
@{blame_result}        if (status == @{P}_OK) {
@{store}
        }
    }
    return status;
}

