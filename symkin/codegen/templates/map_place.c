/* Sets known values and state: @{values} as they are given, and @{source}. */
static @{SHARED} void @{k}_place(@{k}_work *w, const @{real} @{values}[@{nto}], const @{real} @{from}[@{nfrom}])
{
@{lines}
}

