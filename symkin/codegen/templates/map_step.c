solver_place(&w, @values, @from);
solver_rows(&w);
if (@singular) {
    status = NAME_SINGULAR;
} else {
    const name_real size = solver_step(&w);
    name_write_info(info, 1U, @kappa * size, size, w.spread);
}
