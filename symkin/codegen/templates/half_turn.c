name_real h[2];
/* half the turn, by the larger of its cosine and sine */
const name_real larger = sqrt(0.5 + 0.5 * fabs(@cosine));
const name_real lesser = 0.5 * @sine / larger;
if (@cosine >= 0.0) {
    h[0] = larger;
    h[1] = lesser;
} else {
    h[0] = fabs(lesser);
    h[1] = (lesser < 0.0) ? -larger : larger;
}
