if ((status == NAME_WRONG_BRANCH) || (status == NAME_OUT_OF_RANGE)) {
    /* a guess whose own rows vanish is the answer: nothing moves */
    @answer
    @read
    solver_set_target(GEOMETRY &w, @goal, 1.0);
    solver_rows(GEOMETRY &w);
    name_real residual = solver_residual(&w);
    @moved
    const name_real allowed = (config != NULL) ? config->tolerance : NAME_TOLERANCE;
    if (residual <= allowed + @stands) {
        name_write_info(info, 0U, residual, 0.0, w.spread);
        status = NAME_OK;
    }
    @asked
}
