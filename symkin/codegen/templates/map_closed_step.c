static const name_config usual = { NAME_TOLERANCE, NAME_MAX_STEPS, NAME_MAX_STEP };
name_real sign[@signs];
name_real d[@conditions];
name_real least = 1.0;
solver_place(&w, @values, @from);
solver_signs(w.k, w.x, sign, d);
solver_formulas(w.k, sign, w.x, d);
for (int i = 0; i < @conditions; ++i) {
    least = (d[i] < least) ? d[i] : least;
}
status = (least > @not_decided) ? solver_finish(&w, 1U, least, &usual, info) : NAME_SINGULAR;
