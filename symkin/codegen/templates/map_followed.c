static const name_config near = { @near, NAME_MAX_STEPS, NAME_MAX_STEP };
name_real to[@nto];
/* along the line from the reference configuration; an error of a guess moves the beginning of the line by as much */
@starts
@to
status = solver_newton(&w, to, &near, NULL);
@other
