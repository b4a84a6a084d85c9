/* Writes the first joint, from 0, that is outside its range or not finite; the number of joints where none is. */
static NAME_COLD void name_blame(name_info *info, const name_real joints[@{nq}])
{
    static const name_real low[@{nq}] = { @{low} };
    static const name_real high[@{nq}] = { @{high} };
    if (info != NULL) {
        uint8_t joint = 0U;
        while ((joint < @{nq}U) && (joints[joint] >= low[joint]) && (joints[joint] <= high[joint])) {
            ++joint;
        }
        info->joint = joint;
    }
}

