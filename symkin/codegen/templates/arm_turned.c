/* Twist of the tool by joint rates, as the description has it. */
name_status name_jacobian(JOINTS_GIVEN, name_real jacobian[@nj])
{
    const name_status status = @own_jacobian(joints, jacobian);
    EACH_WHILE(j, @nq, (status == NAME_OK)) {
        name_real a[6];
        name_real b[6];
        EACH(i, 6) {
            a[i] = jacobian[@nq * i + j];
        }
        @turn
        EACH(i, 6) {
            jacobian[@nq * i + j] = b[i];
        }
    }
    return status;
}

