/* The value of a joint by the pair of its angle or slide, an angle within half a turn of `about`. */
static name_real solver_joint(int i, const name_real pair[2], name_real about)
{
    TABLE(zeros, @nn, @zeros)
    static const bool angular[@nn] = { @angular };
    name_real value = zeros[i] + pair[0];
    if (angular[i]) {
        value = zeros[i] + atan2(pair[1], pair[0]);
        const name_real number = (about - value) * 0.15915494309189535;
        if (fabs(number) > 0.5) {
            value += 6.283185307179586 * (name_real)NEAREST_WHOLE(number);
        }
    }
    return value;
}

