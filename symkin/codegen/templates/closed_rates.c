/* Derivatives of the actuated joints by the twist of the platform, joint by joint; SINGULAR at a dead centre. */
static @{p}_status @{k}_rates(const @{real} c[@{nc}], @{real} rates[@{rates}])
{
    @{rates_lines}
}

