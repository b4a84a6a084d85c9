/* Checks the pose of an answer, as it is written: whether the limbs there, solved as @{p}_inverse does, have the given joint values. Else
 * a limb has passed a dead centre on the way, which is a singularity, or the line of poses from the reference does not lead
 * to this one: the pose alone would not say where the limb stands. */
static @{COLD} @{p}_status @{p}_check_given(@{gp}const @{real} x[@{nc}], const @{real} given[@{nq}])
{
    static const @{real} near[@{nq}] = { @{near} };
    @{real} q[@{nq}] = { @{zero} };
    @{real} passive[@{np}] = { @{zero} };
    @{real} turned[@{nq}];
    @{real} c[@{nc}];
    @{p}_pose pose;
    @{p}_status status;
    @{p}_pose_from_coordinates(@{ga}x, &pose);
    status = @{p}_pose_coordinates(@{ga}&pose, c);
    if (status == @{P}_OK) {
        status = @{p}_solve_limbs(@{ga}c, q, passive@{feasible});
    }
    if (status == @{P}_OK) {
@{within_given}
        @{p}_unwrap_joints(q, given, turned);
        for (int i = 0; i < @{nq}; ++i) {
            if (!(@{fabs}(turned[i] - q[i]) <= near[i])) {
                status = @{P}_WRONG_BRANCH;
            }
        }
    } else {
        status = @{P}_WRONG_BRANCH;
    }
    return status;
}

