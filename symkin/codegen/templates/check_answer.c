
/* Whether a pose leaves the joints that are not actuated within their limits. */
static @{p}_status @{p}_check_answer(const @{p}_pose *pose)
{
    @{real} c[@{nc}];
    @{real} q[@{nq}] = { @{zero} };
    @{real} passive[@{np}] = { @{zero} };
    @{p}_status status = @{p}_pose_coordinates(pose, c);
    if (status == @{P}_OK) {
        status = @{p}_solve_limbs(c, q, passive@{of_answer});
    }
    if (status == @{P}_OK) {
        status = @{p}_check_passive(c, q, passive);
    }
    return status;
}
