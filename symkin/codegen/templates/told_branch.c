/* Checks the branch of an answer, passive joints and pose coordinates x: whether each limb stands on the reference's side of its dead
 * centres, which is a sign. Else a limb has passed one on the way, which is a singularity. Beside a dead centre the pose, rounded, may
 * lie beyond it: where the pose does not give the joint values back none is OK, and where it does not tell the side only what stands still,
 * from the guess's joint values `at`. */
static @{COLD} @{p}_status @{p}_check_branch(@{gp}const @{real} x[@{count}], const @{real} at[@{nq}], const @{real} given[@{nq}])
{
    static const @{real} near[@{nq}] = { @{near} };
    @{p}_status status = @{P}_OK;
    bool firm = true;
    bool told = true;
    (void)x;
@{told}
    for (int i = 0; (i < @{nq}) && !told; ++i) {
        if (!(@{fabs}(given[i] - at[i]) <= near[i])) {
            status = @{P}_WRONG_BRANCH;
        }
    }
    if ((status == @{P}_OK) && !firm) {
        status = @{p}_check_given(@{ga}@{answer}, given);
    }
    return status;
}

