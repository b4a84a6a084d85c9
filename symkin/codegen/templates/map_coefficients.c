/* What the rows read of the known values: coefficients, by the numbers of these. */
static @{SHARED} void @{k}_coefficients(const @{real} numbers[@{numbers}], @{real} k[@{nk}])
{
@{lines}
}

