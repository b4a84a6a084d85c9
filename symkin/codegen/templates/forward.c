/* Tool pose (x, y, z, qw, qx, qy, qz) of joint values: the product of the joints' turns and slides. */
static void @{p}_forward(@{gp}const @{real} q[@{nq}], @{real} x[7])
{
@{use}
@{forward}
}

