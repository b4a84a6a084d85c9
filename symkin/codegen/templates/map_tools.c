@{angle}
/* Cosine and sine of an angle@{circle_error}. */
static @{SHARED} void @{p}_circle(@{real} angle, @{real} circle[2])
{
@{circle}
}

/* An angle moved by whole turns: the one next to `near` within the limits, where they hold one. */
static @{SHARED} @{real} @{p}_turned(@{real} angle, @{real} near, @{real} low, @{real} high)
{
    const @{real} number = (near - angle) * @{per_turn};
    @{real} moved = angle + @{turn} * (@{real})(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
    if (moved > high) {
        moved -= @{turn};
    } else if (moved < low) {
        moved += @{turn};
    } else {
        /* within */
    }
    return moved;
}

/* Whether values are finite and within their ranges: NONFINITE comes before what was found so far, OUT_OF_RANGE after. */
static @{SHARED} @{p}_status @{p}_check_range(@{p}_status before, const @{real} values[], const @{real} low[], const @{real} high[], int count)
{
    bool within = true;
    for (int i = 0; i < count; ++i) {
        within = within && (values[i] >= low[i]) && (values[i] <= high[i]);
    }
    return within ? before : @{p}_check_finite(values, count, (before == @{P}_OK) ? @{P}_OUT_OF_RANGE : before);
}

/* Ranges of the joints and of the found coordinates, and of guesses, which need not keep to the limits. */
@{ranges}

/* Writes the first joint, from 0, that is outside its range or not finite; the number of joints where none is. */
static @{SHARED} void @{p}_blame(@{p}_info *info, const @{real} joints[@{nq}])
{
    if (info != NULL) {
        uint8_t joint = 0U;
        while ((joint < @{nq}U) && (joints[joint] >= @{p}_low_joints[joint]) && (joints[joint] <= @{p}_high_joints[joint])) {
            ++joint;
        }
        info->joint = joint;
    }
}

