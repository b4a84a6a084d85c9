name_real x[7];
for (int i = 0; i < 7; ++i) {
    x[i] = at[i] + (end * move[i]);
}
if (end < 1.0) {
    const name_real inverse = 1.0 / sqrt((x[3] * x[3]) + (x[4] * x[4]) + (x[5] * x[5]) + (x[6] * x[6]));
    for (int i = 3; i < 7; ++i) {
        x[i] *= inverse;
    }
} else {
    for (int i = 0; i < 7; ++i) {
        x[i] = (i < 3) ? to[i] : (side * to[i]);
    }
}
const name_status reached = solver_aim(w, x);
above = (reached == NAME_OK);