TABLE(sign, @signs, @home_signs)
name_real k[@nk];
name_real x[@ns];
name_real d[@conditions];
@circles
solver_formulas(k, sign, x, d);
EACH(i, @conditions) {
    if (!(d[i] > @resolved)) {
        status = NAME_OUT_OF_RANGE;
    }
}
