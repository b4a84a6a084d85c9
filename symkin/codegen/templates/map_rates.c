/* Whether values are from `least` to what products and sums bear. */
static @{p}_status @{p}_check_sizes(const @{real} values[@{nq}], @{real} least)
{
    @{p}_status status = @{p}_check_finite(values, @{nq}, @{P}_OK);
    for (int i = 0; (i < @{nq}) && (status == @{P}_OK); ++i) {
        status = ((values[i] < least) || (values[i] > @{largest})) ? @{P}_OUT_OF_RANGE : @{P}_OK;
    }
    return status;
}

/* The largest number, up to @{largest}, that times each of the effects, which are `apart` from each other, is within its limit. */
static @{real} @{p}_alone(const @{real} *effects, int apart, const @{real} limits[@{nq}])
{
    @{real} most = @{largest};
    for (int j = 0; j < @{nq}; ++j) {
        const @{real} effect = @{fabs}(effects[apart * j]);
        most = (effect * most > limits[j]) ? (limits[j] / effect) : most;
    }
    return most;
}

