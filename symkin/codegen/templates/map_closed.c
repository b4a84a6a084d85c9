/* Formulas of the @{which} problem (README.md): numbers x of the unknowns for known numbers k, by a sign for each choice between two
 * values. Conditions d are above 0 where all is real and nothing vanishes that is divided by; they are 1 at a usual place. */
static @{SHARED} void @{k}_formulas(const @{real} k[@{nk}], const @{real} sign[@{signs}], @{real} x[@{ns}], @{real} d[@{conditions}])
{
    (void)k;
    (void)sign;
    (void)d;
@{formulas}
}

@{told}
/* The end of the straight line of known values from w->at, where the state is w->x at w->k, to `to`, if no condition vanishes on the way: between two points whose least
 * value of a condition is g it stays above 0 where g > M s^2 / 8, s the way between them and M the condition's largest bend (README.md
 * says which are proved). Then the rows are held against the answer. */
static @{p}_status @{k}_follow(@{k}_work *w, const @{real} to[@{nto}], const @{p}_config *config, @{p}_info *info)
{
@{bends}
    @{real} sign[@{signs}];
    @{real} begin[@{conditions}];
    @{real} end[@{conditions}];
    @{real} done = @{zero};
    @{real} part = @{one};
    @{real} least = @{zero};
    @{real} way2 = @{zero};
    @{p}_status status = @{P}_MAX_ITERATIONS;
    unsigned int count = 0U;
@{way}
    @{k}_signs(w->k, w->x, sign, begin);
@{sides}
    while ((count < (unsigned int)config->max_iterations) && (status == @{P}_MAX_ITERATIONS)) {
        const @{real} aim = (done + part < @{near_one}) ? (done + part) : @{one};
        bool held = true;
        ++count;
        @{k}_set_target(w, to, aim);
        @{k}_formulas(w->k, sign, w->x, end);
@{sides_of_end}
        least = @{one};
@{hold}
        if (held && (aim >= @{one})) {
            status = @{P}_OK;
        } else if (held) {
            done = aim;
            part += part;
            for (int i = 0; i < @{conditions}; ++i) {
                begin[i] = end[i];
            }
        } else if (part > @{least_part}) {
            part *= @{half};
        } else {
            /* parts have become too short: a singularity is at hand */
            status = @{P}_WRONG_BRANCH;
        }
    }
    if (status == @{P}_OK) {
        status = @{k}_finish(w, count, least, config, info);
    } else {
        @{p}_write_info(info, count, @{huge}, @{zero}, @{zero});
    }
    return status;
}

