/* Whether the joints that are neither given nor found are within their limits in a state w of known values. */
static @{SHARED} @{p}_status @{k}_check_passive(const @{k}_work *w, const @{real} @{values}[@{nto}])
{
    @{p}_status status = @{P}_OK;
    (void)w;
    (void)@{values};
@{lines}
    return status;
}

