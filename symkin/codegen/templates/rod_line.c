
/* Whether all coefficients are at least 0: the polynomial is, then. */
static bool @{p}_all_above(const @{real} c[7])
{
    bool above = true;
    for (int i = 0; i < 7; ++i) {
        above = above && (c[i] >= @{zero});
    }
    return above;
}

/* Whether a polynomial of degree 6 stays at or above 0 from 0 to 1, by its Bernstein coefficients there: it lies between the least and
 * the largest of them. Parts are cut off the beginning while that does not decide. */
static @{p}_status @{p}_stays_above(@{real} c[7], unsigned int most, unsigned int *count)
{
    @{p}_status status = ((c[0] >= @{zero}) && (c[6] >= @{zero})) ? @{P}_OK : @{P}_OUT_OF_RANGE;
    @{real} part = @{half};
    bool above = @{p}_all_above(c);
    while ((*count < most) && (status == @{P}_OK) && !above) {
        @{real} left[7];
        @{real} right[7];
        ++*count;
        for (int i = 0; i < 7; ++i) {
            right[i] = c[i];
        }
        /* de Casteljau */
        for (int k = 0; k < 7; ++k) {
            left[k] = right[0];
            for (int i = 0; i < 6 - k; ++i) {
                right[i] += part * (right[i + 1] - right[i]);
            }
        }
        if (right[0] < @{zero}) {
            status = @{P}_OUT_OF_RANGE;
        } else if (@{p}_all_above(left)) {
            for (int i = 0; i < 7; ++i) {
                c[i] = right[i];
            }
            part = @{half};
            above = @{p}_all_above(c);
        } else {
            part *= @{half};
            if (part < @{least_part}) {
                status = @{P}_OUT_OF_RANGE;
            }
        }
    }
    if ((status == @{P}_OK) && !above) {
        status = @{P}_MAX_ITERATIONS;
    }
    return status;
}

/* Adds the square of a cubic, by its Bernstein coefficients, times a factor. */
static void @{p}_add_square(const @{real} b[4], @{real} factor, @{real} c[7])
{
    c[0] += factor * (b[0] * b[0]);
    c[1] += factor * (b[0] * b[1]);
    c[2] += factor * (@{two_fifths} * (b[0] * b[2]) + @{three_fifths} * (b[1] * b[1]));
    c[3] += factor * (@{tenth} * (b[0] * b[3]) + @{nine_tenths} * (b[1] * b[2]));
    c[4] += factor * (@{two_fifths} * (b[1] * b[3]) + @{three_fifths} * (b[2] * b[2]));
    c[5] += factor * (b[2] * b[3]);
    c[6] += factor * (b[3] * b[3]);
}

/* Joint limits along the line of poses. With the quaternion q0 + t (q1 - q0), whose squared length is n, the vector n d of a rod is a
 * cubic in t, by its values at both ends and at the middle pose, and n^2 (|d|^2 - L^2) is of degree 6. */
@{p}_status @{p}_line(@{gp}const @{p}_config *config, const @{p}_pose *from, const @{p}_pose *to, @{p}_info *info)
{
    static const @{real} low[6] = { @{lows} };
    static const @{real} high[6] = { @{highs} };
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
    const @{p}_config *const used = (config == NULL) ? &usual : config;
    const unsigned int most = (unsigned int)used->max_iterations;
    const @{real} third = @{third};
    @{p}_direct_work w;
    @{real} ends[2][7];
    @{real} rods[3][18]; /* at the beginning, in the middle and at the end */
    @{real} offset[6];
    uint8_t joint = 6U;
    unsigned int count = 1U;
    const @{p}_status last = @{p}_normalise_pose(@{ga}to, ends[1]);
    @{p}_status status = @{p}_normalise_pose(@{ga}from, ends[0]);
    status = ((status == @{P}_OK) || (last == @{P}_NONFINITE)) ? last : status;
    if (config != NULL) {
        status = @{p}_check_config(config, status);
    }
    if ((status == @{P}_OK) && (most == 0U)) {
        status = @{P}_MAX_ITERATIONS;
        count = 0U;
    }
    for (int e = 0; (e < 2) && (status == @{P}_OK); ++e) {
        for (int i = 0; i < 7; ++i) {
            w.x[i] = ends[e][i];
        }
        @{p}_rod_values(@{ga}&w);
        status = @{p}_check_limits(@{ga}w.k);
        joint = @{p}_first_beyond(@{ga}w.k);
        for (int i = 0; i < 18; ++i) {
            rods[2 * e][i] = w.d[i];
        }
        for (int i = 0; i < 6; ++i) {
            const @{real} *const d = &w.d[3 * i];
            offset[i] = @{sqrt}(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]) - w.k[i];
        }
    }
    if (status == @{P}_OK) {
        const @{real} *const a = &ends[0][3];
        const @{real} *const b = &ends[1][3];
        const @{real} product = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
        /* of q and -q, one rotation, the one that is nearer */
        const @{real} side = (product < @{zero}) ? -@{one} : @{one};
        const @{real} cosine = (side * product < @{one}) ? (side * product) : @{one};
        const @{real} both = @{two} * (@{one} + cosine);
        const @{real} inverse = @{one} / @{sqrt}(both);
        const @{real} square[4] = { @{one}, third * (@{one} + @{two} * cosine), third * (@{one} + @{two} * cosine), @{one} };
        for (int i = 0; i < 3; ++i) {
            w.x[i] = @{half} * (ends[0][i] + ends[1][i]);
        }
        for (int i = 0; i < 4; ++i) {
            w.x[3 + i] = inverse * (a[i] + side * b[i]);
        }
        @{p}_direct_rows(@{ga}&w);
        for (int i = 0; i < 18; ++i) {
            rods[1][i] = w.d[i];
        }
        for (int i = 0; (i < 6) && (status == @{P}_OK); ++i) {
            const @{real} least = low[i] + offset[i];
            const @{real} longest = high[i] + offset[i];
            @{real} above[7] = { @{zero} };
            @{real} below[7] = { @{zero} };
            for (int k = 0; k < 3; ++k) {
                const @{real} first = rods[0][3 * i + k];
                const @{real} middle = both * rods[1][3 * i + k];
                const @{real} end = rods[2][3 * i + k];
                const @{real} way = (@{one} - cosine) * (ends[1][k] - ends[0][k]);
                const @{real} cubic[4] = { first, third * (middle - end + way), third * (middle - first - way), end };
                @{p}_add_square(cubic, @{one}, above);
            }
            for (int k = 0; k < 7; ++k) {
                below[k] = -above[k];
            }
            @{p}_add_square(square, -(least * @{fabs}(least)), above);
            @{p}_add_square(square, longest * @{fabs}(longest), below);
            status = @{p}_stays_above(above, most, &count);
            if (status == @{P}_OK) {
                status = @{p}_stays_above(below, most, &count);
            }
            joint = (status == @{P}_OUT_OF_RANGE) ? (uint8_t)i : joint;
        }
    }
    @{p}_write_info(info, count, (status == @{P}_OK) ? @{zero} : @{huge}, @{zero}, @{zero});
    if (info != NULL) {
        info->joint = joint;
    }
    return status;
}
