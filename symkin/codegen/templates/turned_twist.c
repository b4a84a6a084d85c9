
/* The twist of joint rates in the base frame, of which the machine's own frame is turned. */
@{p}_status @{p}_twist(const @{p}_pose *pose, const @{real} rates[@{nq}], @{real} twist[6])
{
    @{real} own[6];
    const @{p}_status status = @{own}(pose, rates, own);
    if (status == @{P}_OK) {
        const @{real} *const a = own;
        @{real} *const b = twist;
@{turned_row}
    }
    return status;
}
