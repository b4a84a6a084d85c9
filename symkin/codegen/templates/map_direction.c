/* Whether the @values lead from the reference configuration to the guess, which then has nowhere to go, though the @out alone lead
 * elsewhere: sets the numbers y of a configuration on this way, where its known values are, and the @out to which they lead. */
static NAME_COLD bool @{f}_stands(VALUES_GIVEN, const name_real guess[@nout], name_real y[@ny], name_real at[@nto],
    name_real other[@nout])
{
    if (name_state_of_@values(@values, y, other) != NAME_OK) {
        return false;
    }
    @stand_at
    return name_@{out}_away2(other, guess) <= @stands2;
}

/* The @out at the end of the line from a configuration, with the numbers y and the known values `at`, to the given ones. */
static NAME_SHARED name_status @{f}_line(solver_work *w, VALUES_GIVEN, const name_real y[@ny], const name_real at[@nto],
    const name_real guess[@nout], name_real result[@nout], CONFIG_AND_INFO)
{
    name_status status;
    @begin
    @follow
    IF_OK {
        @line_results
    }
    return status;
}

/* Whether a configuration has the given values but for rounding, and with which residual: sets the state to it. */
static NAME_SHARED bool @{f}_closes(solver_work *w, VALUES_GIVEN, const name_real @from[@nfrom],
    const name_config *config, name_real *residual)
{
    solver_place(w, @values, @from);
    solver_rows(w);
    *residual = solver_residual(w);
    return *residual <= config->tolerance + @rounding;
}

/* Whether an answer can be held: read as a guess it has the given values, or leads to itself. */
static NAME_SHARED bool @{f}_holds(solver_work *w, VALUES_GIVEN, const name_real answer[@nout], const name_config *config)
{
    name_real y[@ny];
    name_real at[@nto];
    name_real again[@nout];
    name_real residual;
    if (name_state_of_@out(answer, y, at) != NAME_OK) {
        return false;
    }
    return @{f}_closes(w, @values, @answer_from, config, &residual)
        || ((@{f}_line(w, @values, y, at, answer, again, config, NULL) == NAME_OK)
            && (name_@{out}_away2(again, answer) <= @same2));
}

/* @about */
name_status @f(const name_config *config, VALUES_GIVEN, const name_real guess[@nout], name_real @out[@nout],
    name_info *info)
{
    USUAL_CONFIG
    const name_config *const used = (config != NULL) ? config : &usual;
    solver_work w;
    name_real y[@ny];
    name_real at[@nto];
    name_real result[@nout];
    name_real other[@nout];
    name_status status = name_limit_@values(NAME_OK, @values);
    status = name_bound_@out(status, guess);
    CHECK_CONFIG
    const bool asked = (status == NAME_OK);
    if (asked) {
        status = name_state_of_@out(guess, y, at);
    }
    if (status != NAME_OK) {
        @no_step
    } else {
        name_real residual;
        bool still = @{f}_closes(&w, @values, @guess_from, used, &residual);
        status = @{f}_line(&w, @values, y, at, guess, result, used, info);
        if ((status == NAME_OK) && !@{f}_holds(&w, @values, result, used)) {
            /* a guess that leads to itself is held, whatever its answer does */
            still = still || (name_@{out}_away2(result, guess) <= @same2);
            status = NAME_WRONG_BRANCH;
        }
        @drifted
        if (still && ((status == NAME_WRONG_BRANCH) || (status == NAME_SINGULAR))) {
            /* the guess itself is an answer */
            status = NAME_OK;
            solver_place(&w, @values, @guess_from);
            COPY(result, guess, @nout)
            name_write_info(info, 0U, residual, 0.0, 0.0);
        }
    }
    if (asked && (status != NAME_OK) && @{f}_stands(@values, guess, y, at, other)) {
        status = @{f}_line(&w, @values, y, at, guess, result, used, info);
        if ((status == NAME_OK) && (name_@{out}_away2(other, result) > @stands2)) {
            status = NAME_WRONG_BRANCH;
        }
    }
    IF_OK {
        status = name_limit_@out(status, result);
        @passive
        IF_OK {
            @store
        }
        @blame_result
    }
    return status;
}

/* @about_track */
name_status @track(VALUES_GIVEN, name_real @out[@nout], name_info *info)
{
    solver_work w;
    @y
    name_status status = name_limit_@values(NAME_OK, @values);
    status = name_bound_@out(status, @out);
    @last
    IF_OK {
        @step
    } else {
        @no_step
    }
    IF_OK {
        @track_results
        name_real change2 = 0.0;
        @change
        /* beyond a small step the branch is not assured */
        status = (change2 <= @track2) ? NAME_OK : NAME_WRONG_BRANCH;
        status = name_limit_@out(status, result);
        @passive
        IF_OK {
            @store
        }
        @blame_result
    }
    return status;
}

