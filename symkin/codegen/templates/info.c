/* Writes the info of a call: steps taken, predicted error, root of the squared last step, smallest pivot from the spread of
 * the pivots. Never a NaN. */
static @{COLD} void @{p}_write_info(@{p}_info *info, unsigned int count, @{real} residual, @{real} size, @{real} spread)
{
    if (info != NULL) {
        info->iterations = (uint8_t)count;
        info->residual = (residual >= @{zero}) ? residual : @{huge};
        info->step = (size >= @{zero}) ? @{sqrt}(size) : @{huge};
        info->min_pivot = (spread > @{zero}) ? (@{one} / @{sqrt}(spread)) : @{zero};
    }
}


