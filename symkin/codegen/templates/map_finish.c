/* Holds the rows against the formulas' answer; one step of Newton's method where rounding has left more than the tolerance. */
static @{SHARED} @{p}_status @{k}_finish(@{k}_work *w, unsigned int count, @{real} least, const @{p}_config *config, @{p}_info *info)
{
    @{real} size = @{zero};
    @{k}_rows(w);
    @{real} residual = @{k}_residual(w);
    if (!(residual <= config->tolerance)) {
        if (@{singular}) {
            @{p}_write_info(info, count, residual, @{zero}, @{zero});
            return @{P}_SINGULAR;
        }
        @{k}_solve(w);
        size = @{k}_apply_step(w);
        @{k}_rows(w);
        residual = @{k}_residual(w);
    }
    @{p}_write_info(info, count, residual, size, (least > @{zero}) ? (@{one} / least) : @{zero});
    return (residual <= config->tolerance + @{rounding}) ? @{P}_OK : @{P}_MAX_ITERATIONS;
}

