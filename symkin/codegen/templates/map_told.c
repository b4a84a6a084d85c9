/* The signs of a configuration in the formulas. */
static @{SHARED} void @{k}_signs(const @{real} k[@{nk}], const @{real} x[@{ns}], @{real} sign[@{signs}])
{
    (void)k;
    (void)x;
@{lines}
}

