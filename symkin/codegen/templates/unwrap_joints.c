/* Unwraps joint values: takes whole turns off angles without limits, so that the nearer way from `at` is meant. */
static void name_unwrap_joints(const name_real at[@{nq}], const name_real joints[@{nq}], name_real given[@{nq}])
{
    static const bool turns[@{nq}] = { @{turns} };
    for (int i = 0; i < @{nq}; ++i) {
        const name_real change = joints[i] - at[i];
        given[i] = joints[i];
        if (turns[i] && (@{fabs}(change) < @{many})) {
            const name_real number = change * @{per_turn};
            const int whole = (int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
            given[i] = joints[i] - @{turn} * (name_real)whole;
        }
    }
}

