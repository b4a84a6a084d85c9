/* Twist of the tool by joint rates, as the description has it. */
name_status name_jacobian(const name_real joints[@nq], name_real jacobian[@nj])
{
    const name_status status = @own_jacobian(joints, jacobian);
    for (int j = 0; (j < @nq) && (status == NAME_OK); ++j) {
        name_real a[6];
        name_real b[6];
        for (int i = 0; i < 6; ++i) {
            a[i] = jacobian[@nq * i + j];
        }
        @turn
        for (int i = 0; i < 6; ++i) {
            jacobian[@nq * i + j] = b[i];
        }
    }
    return status;
}

