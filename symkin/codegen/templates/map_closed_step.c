USUAL_CONFIG
name_real sign[@signs];
name_real d[@conditions];
name_real least = 1.0;
solver_place(&w, @values, @from);
solver_signs(w.k, w.x, sign, d);
solver_formulas(w.k, sign, w.x, d);
EACH(i, @conditions) {
    least = (d[i] < least) ? d[i] : least;
}
status = (least > @not_decided) ? solver_finish(&w, 1U, least, &usual, info) : NAME_SINGULAR;
