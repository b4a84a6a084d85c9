/* The pose with its quaternion of unit length: (x, y, z, qw, qx, qy, qz). Lengths off by more than 1e-2 are refused. */
static @{p}_status @{p}_unit(const @{p}_pose *pose, @{real} x[7])
{
    const @{real} *const q = pose->quaternion;
    const @{real} squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    @{p}_status status = @{P}_OK;
    x[0] = pose->position[0];
    x[1] = pose->position[1];
    x[2] = pose->position[2];
    if ((squared >= @{least_norm}) && (squared <= @{most_norm})) {
        const @{real} inverse = @{one} / @{sqrt}(squared);
        x[3] = q[0] * inverse;
        x[4] = q[1] * inverse;
        x[5] = q[2] * inverse;
        x[6] = q[3] * inverse;
    } else {
        x[3] = q[0];
        x[4] = q[1];
        x[5] = q[2];
        x[6] = q[3];
        status = @{p}_verdict(q, 4, @{P}_OUT_OF_RANGE);
    }
    return status;
}

