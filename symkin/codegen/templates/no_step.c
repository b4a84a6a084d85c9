/* Writes the info of a call that takes no step: no number is known but which joint is the first that is outside its range or not
 * finite. */
static @{COLD} void @{p}_write_no_step(@{gp}@{p}_info *info, const @{real} joints[@{nq}])
{
    @{p}_write_info(info, 0U, @{huge}, @{zero}, @{zero});
    if (info != NULL) {
        info->joint = @{p}_first_beyond(@{ga}joints);
    }
}

