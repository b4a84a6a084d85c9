/* Turns limited angles by whole turns towards `near`, as far as their limits allow: a pose does not tell turns. */
static void @{p}_turn_into_limits(@{real} at[@{nq}], const @{real} near[@{nq}])
{
    static const bool limited[@{nq}] = { @{limited} };
    static const @{real} low[@{nq}] = { @{low} };
    static const @{real} high[@{nq}] = { @{high} };
    for (int i = 0; i < @{nq}; ++i) {
        const @{real} number = (near[i] - at[i]) * @{per_turn};
        if (limited[i] && (@{fabs}(number) < @{many})) {
            const int whole = (int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
            @{real} moved = at[i] + @{turn} * (@{real})whole;
            if (moved > high[i]) {
                moved -= @{turn};
            } else if (moved < low[i]) {
                moved += @{turn};
            } else {
                /* within */
            }
            if ((moved >= low[i]) && (moved <= high[i])) {
                at[i] = moved;
            }
        }
    }
}

