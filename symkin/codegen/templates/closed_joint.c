/* The value of a joint by the pair of its angle or slide, an angle within half a turn of `about`. */
static name_real solver_joint(int i, const name_real pair[2], name_real about)
{
    static const name_real zeros[@{nn}] = { @{zeros} };
    static const bool angular[@{nn}] = { @{angular} };
    name_real value = zeros[i] + pair[0];
    if (angular[i]) {
        value = zeros[i] + @{arctangent2}(pair[1], pair[0]);
        const name_real number = (about - value) * @{per_turn};
        if (@{fabs}(number) > @{half}) {
            value += @{turn} * (name_real)(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
        }
    }
    return value;
}

