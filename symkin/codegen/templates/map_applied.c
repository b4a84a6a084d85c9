/* @{about} */
@{p}_status @{p}_@{function}(const @{real} joints[@{nq}], const @{real} found[@{nq}], const @{real} @{given}[@{nq}], @{real} @{asked}[@{count}])
{
    @{real} @{matrix}[@{nj}];
    @{p}_status status = @{p}_check_sizes(@{given}, @{least});
    if (status == @{P}_OK) {
        status = @{p}_@{matrix}(joints, found, @{matrix});
    }
    if (status == @{P}_OK) {
        @{real} result[@{count}];
        for (int i = 0; i < @{count}; ++i) {
@{body}
        }
        status = @{p}_give(result, @{asked}, @{count});
    }
    return status;
}

