name_real x[7];
EACH(i, 7) {
    x[i] = at[i] + (end * move[i]);
}
if (end < 1.0) {
    const name_real inverse = 1.0 / sqrt(QUATERNIONS_DOT(x, x));
    EACH_FROM(i, 3, 7) {
        x[i] *= inverse;
    }
} else {
    EACH(i, 7) {
        x[i] = (i < 3) ? to[i] : (side * to[i]);
    }
}
const name_status reached = solver_aim(w, x);
above = (reached == NAME_OK);