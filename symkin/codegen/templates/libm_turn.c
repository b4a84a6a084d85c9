/* Cosine and sine of an angle. */
static void name_cosine_and_sine(name_real angle, name_real u[2])
{
    u[0] = @cos(angle);
    u[1] = @sin(angle);
}

