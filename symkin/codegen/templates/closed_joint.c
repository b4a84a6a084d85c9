/* The value of a joint by the pair of its angle or slide, an angle within half a turn of `about`. */
static @{real} @{k}_joint(int i, const @{real} pair[2], @{real} about)
{
    static const @{real} zeros[@{nn}] = { @{zeros} };
    static const bool angular[@{nn}] = { @{angular} };
    @{real} value = zeros[i] + pair[0];
    if (angular[i]) {
        value = zeros[i] + @{arctangent2}(pair[1], pair[0]);
        const @{real} number = (about - value) * @{per_turn};
        if (@{fabs}(number) > @{half}) {
            value += @{turn} * (@{real})(int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
        }
    }
    return value;
}

