/* Checks the answer in w->y, residual of all rows and sides of the limbs' dead centres, and writes its pose. *is_firm: whether it is so far
 * from folds and dead centres that rounding does not reach them. */
static @{p}_status @{p}_direct_answer(const @{p}_direct_work *w, @{real} tolerance, @{p}_pose *pose, @{real} *residual, bool *is_firm)
{
    @{p}_status status = @{P}_OK;
    @{half_lines}
@{residual_lines}
    if (!(*residual <= tolerance + @{rounding})) {
        status = @{P}_SINGULAR;
    }
@{firm_lines}
@{side_lines}
    *is_firm = firm;
    if (status == @{P}_OK) {
@{pose_lines}
    }
    return status;
}

