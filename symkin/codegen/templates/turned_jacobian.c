/* Joint rates by the platform's twist in the base frame, of which the machine's own frame is turned. */
@{p}_status @{p}_jacobian(const @{p}_pose *pose, @{real} rates[@{nq} * 6])
{
    @{real} own[@{nq} * 6];
    const @{p}_status status = @{own}(pose, own);
    if (status == @{P}_OK) {
        for (int i = 0; i < @{nq}; ++i) {
            const @{real} *const a = &own[6 * i];
            @{real} *const b = &rates[6 * i];
@{turned_row}
        }
    }
    return status;
}

