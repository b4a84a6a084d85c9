/* Whether the limbs at the answer, solved as @{p}_inverse does, have the given joint values. Else a limb has passed a dead
 * centre on the way, which is a singularity, or the line of poses from the reference does not lead to this one: the pose alone
 * would not say where the limb stands. */
static @{COLD} @{p}_status @{p}_agrees(@{gp}const @{real} c[@{nc}], const @{real} given[@{nq}])
{
    static const @{real} near[@{nq}] = { @{near} };
    @{real} q[@{nq}] = { @{zero} };
    @{real} passive[@{np}] = { @{zero} };
    @{real} turned[@{nq}];
    @{p}_status status = @{p}_limbs(@{ga}c, q, passive);
    if (status == @{P}_OK) {
@{within_given}
        (void)@{p}_towards(q, given, turned);
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

