solver_place(&w, @values, @from);
solver_rows(&w);
if (@singular) {
    status = NAME_SINGULAR;
} else {
    solver_solve(&w);
    const name_real size = solver_apply_step(&w);
    name_write_info(info, 1U, @kappa * size, size, w.spread);
}
