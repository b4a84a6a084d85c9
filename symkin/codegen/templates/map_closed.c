/* Formulas of the @{which} problem (README.md): numbers x of the unknowns for known numbers k, by a sign for each choice between two
 * values. Conditions d are above 0 where all is real and nothing vanishes that is divided by; they are 1 at a usual place. */
static @{SHARED} void @{k}_formulas(const @{real} k[@{nk}], const @{real} sign[@{signs}], @{real} x[@{ns}], @{real} d[@{conditions}])
{
    (void)k;
    (void)sign;
    (void)d;
@{formulas}
}

/* The signs of a configuration in the formulas, and their conditions there: what tells a sign is its root. */
static @{SHARED} void @{k}_signs(const @{real} k[@{nk}], const @{real} x[@{ns}], @{real} sign[@{signs}], @{real} d[@{conditions}])
{
    (void)k;
    (void)x;
    (void)d;
@{told}
}
@{walk}/* The end of the straight line of known values from w->at, where the state is w->x at w->k, to `to`, if no condition vanishes on the way.
 * Then the rows are held against the answer. */
static @{p}_status @{k}_follow(@{k}_work *w, const @{real} to[@{nto}], const @{p}_config *config, @{p}_info *info)
{
    @{real} least = @{one};
    unsigned int count = 0U;
@{reach}
    @{k}_signs(w->k, w->x, w->sign, w->left);
    @{p}_status status = @{k}_walk(w, w->at, to, (unsigned int)config->max_iterations, &count);
    if (status == @{P}_OK) {
        for (int i = 0; i < @{conditions}; ++i) {
            least = (w->guard[i] < least) ? w->guard[i] : least;
        }
        status = @{k}_finish(w, count, least, config, info);
    } else {
        @{p}_write_info(info, count, @{huge}, @{zero}, @{zero});
    }
    return status;
}

