/* Writes the info of a call: steps taken, predicted error, root of the squared last step, smallest pivot from the spread of
 * the pivots. Never a NaN. */
static NAME_COLD void name_write_info(name_info *info, unsigned int count, name_real residual, name_real size, name_real spread)
{
    if (info != NULL) {
        info->iterations = (uint8_t)count;
        info->residual = (residual >= 0.0) ? residual : HUGE_VAL;
        info->step = (size >= 0.0) ? sqrt(size) : HUGE_VAL;
        info->min_pivot = (spread > 0.0) ? (1.0 / sqrt(spread)) : 0.0;
        info->joint = @{nq}U;
    }
}

/* Checks a config; `before` is the status of the other inputs. NaN and infinities come first. */
static NAME_COLD name_status name_check_config(const name_config *config, name_status before)
{
    const name_real tolerance = config->tolerance;
    const name_real longest = config->max_step;
    name_status status = before;
    if (!((tolerance > 0.0) && (longest > 0.0) && (tolerance <= @farthest - longest)) && (before != NAME_NONFINITE)) {
        const name_real none = (tolerance - tolerance) + (longest - longest); /* 0, but NaN for NaN and infinities */
        status = (none <= 0.0) ? NAME_OUT_OF_RANGE : NAME_NONFINITE;
    }
    return status;
}


