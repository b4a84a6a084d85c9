/* Turns limited angles by whole turns towards `near`, as far as their limits allow: a pose does not tell turns. */
static void name_turn_into_limits(name_real at[@{nq}], const name_real near[@{nq}])
{
    static const bool limited[@{nq}] = { @{limited} };
    static const name_real low[@{nq}] = { @{low} };
    static const name_real high[@{nq}] = { @{high} };
    for (int i = 0; i < @{nq}; ++i) {
        const name_real number = (near[i] - at[i]) * @{per_turn};
        if (limited[i] && (@{fabs}(number) < @{many})) {
            const int whole = (int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
            name_real moved = at[i] + @{turn} * (name_real)whole;
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

