
/* @about in the base frame, of which the machine's own frame is turned. */
name_status name_@part(const name_pose *pose, @{given}name_real @found[@count * 6])
{
    name_real own[@count * 6];
    const name_status status = @own(pose, @{rates}own);
    EACH_WHILE(i, @count, (status == NAME_OK)) {
        const name_real *const a = &own[6 * i];
        name_real *const b = &@found[6 * i];
        @turned_row
    }
    return status;
}
