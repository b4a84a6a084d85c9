/* Tool pose (x, y, z, qw, qx, qy, qz) of joint values. */
static void @{p}_forward(@{gp}const @{real} q[@{nq}], @{real} x[7])
{
@{use}
@{forward}
}

