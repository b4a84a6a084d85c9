/* Whether known values are near those of the reference configuration, where polynomials, held against rays through it, come near
 * the wanted ones. */
static @{SHARED} bool @{k}_near_home(const @{real} values[@{nto}], @{real} wanted[@{count}])
{
@{lines}
    return @{within};
}

