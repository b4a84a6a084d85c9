/* Cosine and sine of an angle. */
static void @{p}_cosine_and_sine(@{real} angle, @{real} u[2])
{
    u[0] = @{cos}(angle);
    u[1] = @{sin}(angle);
}

