/* Tool pose (x, y, z, qw, qx, qy, qz) of joint values: the product of the joints' turns and slides. */
static void name_forward(GEOMETRY_GIVEN const name_real q[@nq], name_real x[7])
{
@use
    @forward
}

