/* All numbers y of the configuration that has the values: of angles cosine and sine, in the order given, found, passive. The choices
 * that the values leave are those of the reference configuration. `other` are the values of the other side. */
static @{SHARED} @{p}_status @{p}_state_of_@{values}(const @{real} values[@{nto}], @{real} y[@{ny}], @{real} other[@{nto}])
{
    @{p}_status status = @{P}_OK;
@{lines}
    return status;
}

