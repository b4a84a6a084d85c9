/* Checks the answer in w->y, residual of all rows and sides of the limbs' dead centres, and writes its pose. */
static @{p}_status @{p}_direct_answer(const @{p}_direct_work *w, @{real} tolerance, @{p}_pose *pose, @{real} *residual)
{
    @{p}_status status = @{P}_OK;
@{half_lines}
@{residual_lines}
    if (!(*residual <= tolerance + @{rounding})) {
        status = @{P}_SINGULAR;
    }
@{side_lines}
    if (status == @{P}_OK) {
@{pose_lines}
    }
    return status;
}

