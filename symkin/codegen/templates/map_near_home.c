/* near the reference configuration by one step of Newton's method from polynomials */
name_real @out[@nout];
bool near_home = solver_near_home(values, @out);
if (near_home) {
    solver_place(&w, values, @out);
    solver_rows(&w);
    near_home = !(@singular);
    if (near_home) {
        name_real s[@nf];
        solver_solve(&w, s);
        @others
        @move
        near_home = (@squared <= @longest);
    }
}
if (!near_home) {
    @line
}
