/* Derivatives of the actuated joints by the twist of the platform, joint by joint; SINGULAR at a dead centre. */
static name_status solver_rates(const name_real c[@nc], name_real rates[@rates])
{
    @rates_lines
}

