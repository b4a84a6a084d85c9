/* Unwraps joint values: takes whole turns off angles without limits, so that the nearer way from `at` is meant. Returns how
 * much of the line to try first: angles by at most half a radian. */
static @{real} @{p}_unwrap_joints(const @{real} at[@{nq}], const @{real} joints[@{nq}], @{real} given[@{nq}])
{
    static const bool turns[@{nq}] = { @{turns} };
    static const bool angular[@{nq}] = { @{angular} };
    @{real} widest = @{largest};
    for (int i = 0; i < @{nq}; ++i) {
        @{real} change = joints[i] - at[i];
        given[i] = joints[i];
        if (turns[i] && (@{fabs}(change) < @{many})) {
            const @{real} number = change * @{per_turn};
            const int whole = (int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
            given[i] = joints[i] - @{turn} * (@{real})whole;
            change = given[i] - at[i];
        }
        if (angular[i] && (@{fabs}(change) > widest)) {
            widest = @{fabs}(change);
        }
    }
    return @{largest} / widest;
}

