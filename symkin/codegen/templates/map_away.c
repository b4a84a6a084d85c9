/* Square of how far values of the @out are from others, angles times the size and by whole turns. */
static NAME_ALONE name_real name_@{out}_away2(const name_real other[@nout], const name_real guess[@nout])
{
    name_real away2 = 0.0;
    @away
    return away2;
}

