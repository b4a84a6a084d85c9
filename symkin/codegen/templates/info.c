/* Writes the info of a call: steps taken, predicted error, root of the squared last step, smallest pivot from the spread of
 * the pivots. Never a NaN. */
static @{COLD} void @{p}_write_info(@{p}_info *info, unsigned int count, @{real} residual, @{real} size, @{real} spread)
{
    if (info != NULL) {
        info->iterations = (uint8_t)count;
        info->residual = (residual >= @{zero}) ? residual : @{huge};
        info->step = (size >= @{zero}) ? @{sqrt}(size) : @{huge};
        info->min_pivot = (spread > @{zero}) ? (@{one} / @{sqrt}(spread)) : @{zero};
        info->joint = @{nq}U;
    }
}

/* Checks a config; `before` is the status of the other inputs. NaN and infinities come first. */
static @{COLD} @{p}_status @{p}_check_config(const @{p}_config *config, @{p}_status before)
{
    const @{real} tolerance = config->tolerance;
    const @{real} longest = config->max_step;
    @{p}_status status = before;
    if (!((tolerance > @{zero}) && (longest > @{zero}) && (tolerance <= @{farthest} - longest)) && (before != @{P}_NONFINITE)) {
        const @{real} none = (tolerance - tolerance) + (longest - longest); /* 0, but NaN for NaN and infinities */
        status = (none <= @{zero}) ? @{P}_OUT_OF_RANGE : @{P}_NONFINITE;
    }
    return status;
}


