/* Solves the limb for pose coordinates c, from the reference configuration along the line of poses to c. */
static @{p}_status @{k}_follow_pose(@{gp}@{k}_work *w, const @{real} c[@{nc}])
{
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
    /* state and pose of the reference configuration */
@{begin}
    return @{k}_newton(@{ga}w, c, &usual, NULL);
}

