/* The signs of a configuration in the formulas, and their conditions there: what tells a sign is its root. */
static @{SHARED} void @{k}_signs(const @{real} k[@{nk}], const @{real} x[@{ns}], @{real} sign[@{signs}], @{real} d[@{conditions}])
{
    (void)k;
    (void)x;
    (void)d;
@{lines}
}

