/* Writes the first joint, from 0, that is outside its range or not finite; the number of joints where none is. */
static @{COLD} void @{p}_blame(@{p}_info *info, const @{real} joints[@{nq}])
{
    static const @{real} low[@{nq}] = { @{low} };
    static const @{real} high[@{nq}] = { @{high} };
    if (info != NULL) {
        uint8_t joint = 0U;
        while ((joint < @{nq}U) && (joints[joint] >= low[joint]) && (joints[joint] <= high[joint])) {
            ++joint;
        }
        info->joint = joint;
    }
}

