/* The pose with its quaternion of unit length: (x, y, z, qw, qx, qy, qz). Lengths off by more than 1e-2 are refused. */
static @{p}_status @{p}_unit(const @{p}_pose *pose, @{real} x[7])
{
    const @{real} *const q = pose->quaternion;
    const @{real} squared = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    @{p}_status status = @{P}_OK;
    x[0] = pose->position[0];
    x[1] = pose->position[1];
    x[2] = pose->position[2];
    @{real} inverse = @{one};
    if ((squared >= @{least_norm}) && (squared <= @{most_norm})) {
        inverse = @{one} / @{sqrt}(squared);
    } else {
        status = @{p}_verdict(q, 4, @{P}_OUT_OF_RANGE);
    }
    x[3] = q[0] * inverse;
    x[4] = q[1] * inverse;
    x[5] = q[2] * inverse;
    x[6] = q[3] * inverse;
    return status;
}

/* What is told of a call: steps taken, predicted error, squared last step, spread of the pivots; no NaN is told. */
static @{COLD} void @{p}_tell(@{p}_info *info, unsigned int count, @{real} residual, @{real} size, @{real} spread)
{
    if (info != NULL) {
        info->iterations = (uint8_t)count;
        info->residual = (residual >= @{zero}) ? residual : @{huge};
        info->step = (size >= @{zero}) ? @{sqrt}(size) : @{huge};
        info->min_pivot = (spread > @{zero}) ? (@{one} / @{sqrt}(spread)) : @{zero};
    }
}


