/* Whether values are from `least` to what products and sums bear. */
static name_status name_check_sizes(const name_real values[@{nq}], name_real least)
{
    name_status status = name_check_finite(values, @{nq}, NAME_OK);
    for (int i = 0; (i < @{nq}) && (status == NAME_OK); ++i) {
        status = ((values[i] < least) || (values[i] > @{largest})) ? NAME_OUT_OF_RANGE : NAME_OK;
    }
    return status;
}

/* The largest number, up to @{largest}, that times each of the effects, which are `apart` from each other, is within its limit. */
static name_real name_alone(const name_real *effects, int apart, const name_real limits[@{nq}])
{
    name_real most = @{largest};
    for (int j = 0; j < @{nq}; ++j) {
        const name_real effect = @{fabs}(effects[apart * j]);
        most = (effect * most > limits[j]) ? (limits[j] / effect) : most;
    }
    return most;
}

