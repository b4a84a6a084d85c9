if (status == NAME_WRONG_BRANCH) {
    /* a guess whose own rows vanish is the answer: nothing moves */
    (void)name_read_guess(GEOMETRY &w, joints, guess);
    name_direct_set_target(GEOMETRY &w, given, 1.0);
    name_direct_rows(GEOMETRY &w);
    const name_real residual = name_direct_residual(&w);
    const name_real allowed = (config != NULL) ? config->tolerance : NAME_TOLERANCE;
    if (residual <= allowed + @stands) {
        name_write_info(info, 0U, residual, 0.0, w.spread);
        status = NAME_OK;
    }
    @branch
}
