/* Cosine and sine of half of each joint's angle, a slide and 0 of a slide, into u. */
static @{SHARED} void @{p}_half_turns(const @{real} joints[@{nn}], @{real} u[@{turns}])
{
@{turned}
}

/* Tool pose (x, y, z, qw, qx, qy, qz) of half turns: the position by the chain of the joints' motions, the quaternion as the product of
 * their turns. */
static @{SHARED} void @{p}_pose_of_turns(const @{real} u[@{turns}], @{real} x[7])
{
@{pose_lines}
}

/* Tool pose of joint values. */
static @{SHARED} void @{p}_forward(const @{real} q[@{nn}], @{real} x[7])
{
    @{real} u[@{turns}];
    @{p}_half_turns(q, u);
    @{p}_pose_of_turns(u, x);
}

