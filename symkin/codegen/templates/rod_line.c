
/* Whether all coefficients are at least 0: the polynomial is, then. */
static bool name_all_above(const name_real c[7])
{
    bool above = true;
    EACH(i, 7) {
        above = above && (c[i] >= 0.0);
    }
    return above;
}

/* Whether a polynomial of degree 6 stays at or above 0 from 0 to 1, by its Bernstein coefficients there: it lies between the least and
 * the largest of them. Parts are cut off the beginning while that does not decide. */
static name_status name_stays_above(name_real c[7], unsigned int most, unsigned int *count)
{
    name_status status = ((c[0] >= 0.0) && (c[6] >= 0.0)) ? NAME_OK : NAME_OUT_OF_RANGE;
    name_real part = 0.5;
    bool above = name_all_above(c);
    while ((*count < most) && (status == NAME_OK) && !above) {
        name_real left[7];
        name_real right[7];
        ++*count;
        COPY(right, c, 7)
        /* de Casteljau */
        EACH(k, 7) {
            left[k] = right[0];
            EACH(i, 6 - k) {
                right[i] += part * (right[i + 1] - right[i]);
            }
        }
        if (right[0] < 0.0) {
            status = NAME_OUT_OF_RANGE;
        } else if (name_all_above(left)) {
            COPY(c, right, 7)
            part = 0.5;
            above = name_all_above(c);
        } else {
            part *= 0.5;
            if (part < @least_part) {
                status = NAME_OUT_OF_RANGE;
            }
        }
    }
    if ((status == NAME_OK) && !above) {
        status = NAME_MAX_ITERATIONS;
    }
    return status;
}

/* Adds the square of a cubic, by its Bernstein coefficients, times a factor. */
static void name_add_square(const name_real b[4], name_real factor, name_real c[7])
{
    c[0] += factor * (b[0] * b[0]);
    c[1] += factor * (b[0] * b[1]);
    c[2] += factor * (0.4 * (b[0] * b[2]) + 0.6 * (b[1] * b[1]));
    c[3] += factor * (0.1 * (b[0] * b[3]) + 0.9 * (b[1] * b[2]));
    c[4] += factor * (0.4 * (b[1] * b[3]) + 0.6 * (b[2] * b[2]));
    c[5] += factor * (b[2] * b[3]);
    c[6] += factor * (b[3] * b[3]);
}

/* Joint limits along the line of poses. With the quaternion q0 + t (q1 - q0), whose squared length is n, the vector n d of a rod is a
 * cubic in t, by its values at both ends and at the middle pose, and n^2 (|d|^2 - L^2) is of degree 6. */
name_status name_line(GEOMETRY_GIVEN const name_config *config, const name_pose *from, const name_pose *to, name_info *info)
{
    TABLE(low, 6, @lows)
    TABLE(high, 6, @highs)
    USUAL_CONFIG
    const name_config *const used = (config == NULL) ? &usual : config;
    const unsigned int most = (unsigned int)used->max_iterations;
    const name_real third = @third;
    name_direct_work w;
    name_real ends[2][7];
    name_real rods[3][18]; /* at the beginning, in the middle and at the end */
    name_real offset[6];
    uint8_t joint = 6U;
    unsigned int count = 1U;
    const name_status last = name_normalise_pose(GEOMETRY to, ends[1]);
    name_status status = name_normalise_pose(GEOMETRY from, ends[0]);
    status = ((status == NAME_OK) || (last == NAME_NONFINITE)) ? last : status;
    CHECK_CONFIG
    if ((status == NAME_OK) && (most == 0U)) {
        status = NAME_MAX_ITERATIONS;
        count = 0U;
    }
    EACH_WHILE(e, 2, (status == NAME_OK)) {
        COPY(w.x, ends[e], 7)
        name_rod_values(GEOMETRY &w);
        status = name_limit_joints(GEOMETRY status, w.k);
        joint = name_first_beyond(GEOMETRY w.k);
        COPY(rods[2 * e], w.d, 18)
        EACH(i, 6) {
            const name_real *const d = &w.d[3 * i];
            offset[i] = sqrt(DOT3(d, d)) - w.k[i];
        }
    }
    IF_OK {
        const name_real *const a = &ends[0][3];
        const name_real *const b = &ends[1][3];
        const name_real product = DOT3(a, b) + a[3] * b[3];
        /* of q and -q, one rotation, the one that is nearer */
        const name_real side = (product < 0.0) ? -1.0 : 1.0;
        const name_real cosine = (side * product < 1.0) ? (side * product) : 1.0;
        const name_real both = 2.0 * (1.0 + cosine);
        const name_real inverse = 1.0 / sqrt(both);
        const name_real square[4] = { 1.0, third * (1.0 + 2.0 * cosine), third * (1.0 + 2.0 * cosine), 1.0 };
        EACH(i, 3) {
            w.x[i] = 0.5 * (ends[0][i] + ends[1][i]);
        }
        EACH(i, 4) {
            w.x[3 + i] = inverse * (a[i] + side * b[i]);
        }
        name_direct_rows(GEOMETRY &w);
        COPY(rods[1], w.d, 18)
        EACH_WHILE(i, 6, (status == NAME_OK)) {
            const name_real least = low[i] + offset[i];
            const name_real longest = high[i] + offset[i];
            name_real above[7] = { 0.0 };
            name_real below[7] = { 0.0 };
            EACH(k, 3) {
                const name_real first = rods[0][3 * i + k];
                const name_real middle = both * rods[1][3 * i + k];
                const name_real end = rods[2][3 * i + k];
                const name_real way = (1.0 - cosine) * (ends[1][k] - ends[0][k]);
                const name_real cubic[4] = { first, third * (middle - end + way), third * (middle - first - way), end };
                name_add_square(cubic, 1.0, above);
            }
            EACH(k, 7) {
                below[k] = -above[k];
            }
            name_add_square(square, -(least * fabs(least)), above);
            name_add_square(square, longest * fabs(longest), below);
            status = name_stays_above(above, most, &count);
            IF_OK {
                status = name_stays_above(below, most, &count);
            }
            joint = (status == NAME_OUT_OF_RANGE) ? (uint8_t)i : joint;
        }
    }
    name_write_info(info, count, (status == NAME_OK) ? 0.0 : HUGE_VAL, 0.0, 0.0);
    BLAME(joint)
    return status;
}
