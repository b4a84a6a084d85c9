/* The limb's joints for pose coordinates c, in closed form (README.md): the values of the reference's branch. */
static @{p}_status @{k}_joints(const @{real} c[@{nc}], @{real} x[@{count}])
{
@{joints_lines}
}

