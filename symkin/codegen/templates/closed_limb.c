/* The limb's joints for pose coordinates c, in closed form (README.md): the values of the reference's branch@{within_words}. */
static @{p}_status @{k}_joints(const @{real} c[@{nc}], @{real} x[@{count}]@{within})
{
    @{joints_lines}
}

