static NAME_SHARED void name_jacobian_at(const name_real u[2 * @nn], name_real jacobian[6 * @nn]);

/* Holds the tool's pose of joint values against x. Beside a fold the formulas lose digits, which a step of Newton's method gives back. */
static name_status name_hold(const name_real x[7], name_real joints[@nn], name_real *residual)
{
    name_real e[6];
    name_real u[2 * @nn];
    name_status status = NAME_OK;
    name_half_turns(joints, u);
    *residual = name_error_at(u, x, e);
    if (!(*residual <= @answer_rounding)) {
        name_real jacobian[6 * @nn];
        name_real step[@nn];
        name_jacobian_at(u, jacobian);
        (void)name_damped(jacobian, e, step);
        EACH(i, @nn) {
            joints[i] += step[i];
        }
        name_half_turns(joints, u);
        *residual = name_error_at(u, x, e);
        status = (*residual <= @answer_rounding) ? NAME_OK : NAME_SINGULAR;
    }
    return status;
}

/* Brings the joint values of a branch to where they are wanted: whole turns, their ranges, and the tool's pose held against x. */
static name_status name_settle(const name_real x[7], ABOUT_AND_JOINTS)
{
    name_real residual;
    name_status status = name_turn_near(about, joints);
    IF_OK {
        status = name_hold(x, joints, &residual);
    }
    return status;
}

