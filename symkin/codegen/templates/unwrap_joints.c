/* Unwraps joint values: takes whole turns off angles without limits, so that the nearer way from `at` is meant. */
static void @{p}_unwrap_joints(const @{real} at[@{nq}], const @{real} joints[@{nq}], @{real} given[@{nq}])
{
    static const bool turns[@{nq}] = { @{turns} };
    for (int i = 0; i < @{nq}; ++i) {
        const @{real} change = joints[i] - at[i];
        given[i] = joints[i];
        if (turns[i] && (@{fabs}(change) < @{many})) {
            const @{real} number = change * @{per_turn};
            const int whole = (int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
            given[i] = joints[i] - @{turn} * (@{real})whole;
        }
    }
}

