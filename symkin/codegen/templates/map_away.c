/* Square of how far values of the @{out} are from others, angles times the size and by whole turns. */
static @{ALONE} @{real} @{p}_@{out}_away2(const @{real} other[@{nout}], const @{real} guess[@{nout}])
{
    @{real} away2 = @{zero};
@{away}
    return away2;
}

