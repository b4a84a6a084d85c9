/* Checks the branch of an answer, passive joints and pose coordinates x: whether each limb stands on the reference's side of its dead
 * centres, which is a sign. Else a limb has passed one on the way, which is a singularity. */
static @{COLD} @{p}_status @{p}_check_branch(const @{real} x[@{count}], const @{real} given[@{nq}])
{
    @{p}_status status = @{P}_OK;
    (void)x;
    (void)given;
@{told}
    return status;
}

