/* Holds the tool's pose of joint values against x. Beside a fold the formulas lose digits, which a step of Newton's method gives back. */
static @{p}_status @{p}_hold(const @{real} x[7], @{real} joints[@{nn}], @{real} *residual)
{
    @{real} e[6];
    @{p}_status status = @{P}_OK;
    *residual = @{p}_pose_error(joints, x, e);
    if (!(*residual <= @{answer_rounding})) {
        @{real} jacobian[6 * @{nn}];
        @{real} step[@{nn}];
        status = @{own_jacobian}(joints, jacobian);
        if (status == @{P}_OK) {
            (void)@{p}_damped(jacobian, e, step);
            for (int i = 0; i < @{nn}; ++i) {
                joints[i] += step[i];
            }
            *residual = @{p}_pose_error(joints, x, e);
            status = (*residual <= @{answer_rounding}) ? @{P}_OK : @{P}_SINGULAR;
        }
    }
    return status;
}

/* Brings the joint values of a branch to where they are wanted: whole turns, their ranges, and the tool's pose held against x. */
static @{p}_status @{p}_settle(const @{real} x[7], const @{real} about[@{nn}], @{real} joints[@{nn}])
{
    @{real} residual;
    @{p}_status status = @{p}_turn_near(about, joints);
    if (status == @{P}_OK) {
        status = @{p}_hold(x, joints, &residual);
    }
    return status;
}

