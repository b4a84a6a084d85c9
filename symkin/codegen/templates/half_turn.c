name_real h[2];
/* half the turn, by the larger of its cosine and sine */
const name_real larger = @{sqrt}(@{half} + @{half} * @{fabs}(@{cosine}));
const name_real lesser = @{half} * @{sine} / larger;
if (@{cosine} >= @{zero}) {
    h[0] = larger;
    h[1] = lesser;
} else {
    h[0] = @{fabs}(lesser);
    h[1] = (lesser < @{zero}) ? -larger : larger;
}
