/* Brings joint values of the nearly equal arm, whose axes are parallel or meet as they should, to the tool pose x of this one by
 * Newton's method, near by. */
static @{p}_status @{p}_finish(const @{real} x[7], @{real} joints[@{nn}])
{
    @{k}_work work;
    @{k}_work *const w = &work;
    @{real} residual;
    @{real} size = @{zero};
    int turn = 1;
    for (int i = 0; i < @{nn}; ++i) {
        w->x[i] = joints[i];
    }
    w->spread = @{zero};
    @{p}_forward(w->x, w->at);
    @{k}_set_target(w, x, @{one});
    @{k}_rows(w);
    residual = @{k}_residual(w);
    for (int step = 0; (step < @{most_steps}) && (turn != 0) && (size <= @{longest2}) && (residual > @{P}_TOLERANCE + @{rounding}); ++step) {
@{factor}
        if (turn != 0) {
            @{k}_solve(w);
            size = @{k}_apply_step(w);
            @{k}_rows(w);
            residual = @{k}_residual(w);
        }
    }
    for (int i = 0; i < @{nn}; ++i) {
        joints[i] = w->x[i];
    }
    return (residual <= @{P}_TOLERANCE + @{rounding}) ? @{P}_OK : ((turn == 0) ? @{P}_SINGULAR : @{P}_OUT_OF_RANGE);
}

/* Brings the joint values of a branch to where they are wanted: this arm's pose, whole turns, and their ranges. */
static @{p}_status @{p}_settle(const @{real} x[7], const @{real} about[@{nn}], @{real} joints[@{nn}])
{
    @{p}_status status = @{p}_finish(x, joints);
    if (status == @{P}_OK) {
        status = @{p}_turn_near(about, joints);
    }
    return status;
}
