/* Least and largest values: limits, and bounds of what is guessed, which need not keep to limits. */
@{tables}

/* The first value, from 0, that is outside its range or not finite; the count of values where none is. */
static @{SHARED} uint8_t @{p}_first_beyond(const @{real} values[@{nq}], const @{real} range[2][@{nq}])
{
    uint8_t place = 0U;
    while ((place < @{nq}U) && (values[place] >= range[0][place]) && (values[place] <= range[1][place])) {
        ++place;
    }
    return place;
}

/* Whether values are finite and within their range: NONFINITE comes before what was found so far, OUT_OF_RANGE after. */
static @{p}_status @{p}_within(@{p}_status before, const @{real} values[@{nq}], const @{real} range[2][@{nq}])
{
    @{p}_status status = before;
    if (@{p}_first_beyond(values, range) < @{nq}U) {
        status = @{p}_check_finite(values, @{nq}, (before == @{P}_OK) ? @{P}_OUT_OF_RANGE : before);
    }
    return status;
}

/* Writes the first joint, from 0, that is outside its range or not finite; the number of joints where none is. */
static @{COLD} void @{p}_blame(@{p}_info *info, const @{real} joints[@{nq}])
{
    if (info != NULL) {
        info->joint = @{p}_first_beyond(joints, @{p}_limits_joints);
    }
}

