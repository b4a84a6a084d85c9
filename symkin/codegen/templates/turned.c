
/* @about in the base frame, of which the machine's own frame is turned. */
name_status name_@part(@takes, name_real @found[@count * 6])
{
    name_real own[@count * 6];
    const name_status status = @own(@passed, own);
    EACH_WHILE(i, @count, (status == NAME_OK)) {
        const name_real *const a = &own[@next * i];
        name_real *const b = &@found[@next * i];
        @turned_row
    }
    return status;
}
