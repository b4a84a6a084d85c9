/* Cosine and sine of half of each joint's angle, a slide and 0 of a slide, into u. */
static NAME_SHARED void name_half_turns(const name_real joints[@nn], name_real u[@turns])
{
    @turned
}

/* Tool pose (x, y, z, qw, qx, qy, qz) of half turns: the position by the chain of the joints' motions, the quaternion as the product of
 * their turns. */
static NAME_SHARED void name_pose_of_turns(const name_real u[@turns], name_real x[7])
{
    @pose_lines
}

/* Tool pose of joint values. */
static NAME_SHARED void name_forward(const name_real q[@nn], name_real x[7])
{
    name_real u[@turns];
    name_half_turns(q, u);
    name_pose_of_turns(u, x);
}

