/* quarter turns, each taken off in three parts where there are any, and polynomials of least error within an eighth of a turn */
int quarters = 0;
@{real} x = angle;
if (@{fabs}(angle) > @{eighth}) {
    const @{real} number = angle * @{per_quarter};
    quarters = (int)(number + ((number < @{zero}) ? @{minus_half} : @{half}));
    const @{real} whole = (@{real})quarters;
    x = ((angle - whole * @{quarter1}) - whole * @{quarter2}) - whole * @{quarter3};
}
const @{real} square = x * x;
const @{real} sine = x + x * square * (@{sine});
const @{real} cosine = (@{one} - @{half} * square) + square * square * (@{cosine});
circle[0] = cosine;
circle[1] = sine;
if (quarters != 0) {
    const bool odd = ((unsigned int)quarters & 1U) != 0U;
    const @{real} c = odd ? sine : cosine;
    const @{real} s = odd ? cosine : sine;
    circle[0] = ((((unsigned int)quarters + 1U) & 2U) != 0U) ? -c : c;
    circle[1] = (((unsigned int)quarters & 2U) != 0U) ? -s : s;
}
