/* Solves the limbs for pose coordinates: actuated and passive joints, on the branches of the reference configuration. */
static @{p}_status @{p}_solve_limbs(@{gp}const @{real} c[@{nc}], @{real} q[@{nq}], @{real} passive[@{np}]@{within})
{
    @{p}_status status = @{P}_OK;
    (void)passive;
@{use}
@{limbs}
    return status;
}

