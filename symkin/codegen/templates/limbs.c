/* Joint values of a pose, actuated and passive, on the branches of the reference configuration. */
static @{p}_status @{p}_limbs(@{gp}const @{real} c[@{nc}], @{real} q[@{nq}], @{real} passive[@{np}])
{
    @{p}_status status = @{P}_OK;
    (void)passive;
@{use}
@{limbs}
    return status;
}

