/* The limb's joints for pose coordinates c, in closed form (README.md): the values of the reference's branch. */
static @{p}_status @{k}_joints(const @{real} c[@{nc}], @{real} x[@{count}])
{
@{joints_lines}
}

/* Derivatives of the actuated joints by the twist of the platform, joint by joint; SINGULAR at a dead centre. */
static @{p}_status @{k}_rates(const @{real} c[@{nc}], @{real} rates[@{rates}])
{
@{rates_lines}
}

