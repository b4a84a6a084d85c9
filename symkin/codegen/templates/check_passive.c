
/* Whether joints that are not actuated @{asked}. */
static @{p}_status @{p}_check_passive(@{gp}const @{real} c[@{nc}], const @{real} q[@{nq}], const @{real} passive[@{np}])
{
    @{p}_status status = @{P}_OK;
    (void)c;
    (void)q;
    (void)passive;
@{use}
@{lines}
    return status;
}
