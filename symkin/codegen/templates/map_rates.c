/* The largest number, up to @largest, that times each of the effects, which are `apart` from each other, is within its limit. */
static name_real name_alone(const name_real *effects, int apart, const name_real limits[@nq])
{
    name_real most = @largest;
    EACH(j, @nq) {
        const name_real effect = fabs(effects[apart * j]);
        most = (effect * most > limits[j]) ? (limits[j] / effect) : most;
    }
    return most;
}

