/* Solves the limb for pose coordinates c, from the reference configuration along the line of poses to c. */
static @{p}_status @{k}_at(@{gp}@{k}_work *w, const @{real} c[@{nc}])
{
    static const @{p}_config usual = { @{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP };
@{begin}
    return @{k}_newton(@{ga}w, c, &usual, NULL);
}

/* What the limb's rows lose when the platform moves: minus their derivative by the twist, row by row. */
static void @{k}_sides(@{gp}const @{k}_work *w, @{real} sides[@{count}])
{
@{use}
@{sides}
}

