/* Twist of the tool by joint rates, as the description has it. */
@{p}_status @{p}_jacobian(const @{real} joints[@{nq}], @{real} jacobian[@{nj}])
{
    const @{p}_status status = @{own_jacobian}(joints, jacobian);
    for (int j = 0; (j < @{nq}) && (status == @{P}_OK); ++j) {
        @{real} a[6];
        @{real} b[6];
        for (int i = 0; i < 6; ++i) {
            a[i] = jacobian[@{nq} * i + j];
        }
@{turn}
        for (int i = 0; i < 6; ++i) {
            jacobian[@{nq} * i + j] = b[i];
        }
    }
    return status;
}

