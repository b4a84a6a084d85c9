
/* @{about} in the base frame, of which the machine's own frame is turned. */
@{p}_status @{p}_@{part}(const @{p}_pose *pose, @{given}@{real} @{found}[@{count} * 6])
{
    @{real} own[@{count} * 6];
    const @{p}_status status = @{own}(pose, @{rates}own);
    for (int i = 0; (i < @{count}) && (status == @{P}_OK); ++i) {
        const @{real} *const a = &own[6 * i];
        @{real} *const b = &@{found}[6 * i];
@{turned_row}
    }
    return status;
}
