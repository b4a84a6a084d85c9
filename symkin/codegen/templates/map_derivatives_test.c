/* The sum of products of N numbers each, which stand so far apart, and in *size of their magnitudes. */
static double product(const @{p}_real *a, int apart, const @{p}_real *b, int from, double *size)
{
    double sum = 0.0;
    *size = 1.0;
    for (int i = 0; i < N; ++i) {
        sum += (double)a[apart * i] * (double)b[from * i];
        *size += fabs((double)a[apart * i] * (double)b[from * i]);
    }
    return sum;
}

/* The law of virtual power: joint torques on joint rates do what found torques do on found rates. */
static void power_of(int k)
{
@{configuration_of_k}
    @{p}_real torques[N];
    @{p}_real rates[N];
    @{p}_real of_found[N];
    @{p}_real of_joints[N];
    double size;
    double other;
    for (int i = 0; i < N; ++i) {
        torques[i] = (@{p}_real)(1 + i);
        rates[i] = (@{p}_real)(2 - i);
    }
    expect(@{p}_rates(@{configuration}, rates, of_found) == @{P}_OK, "rates", "OK", k);
    expect(@{p}_torques(@{configuration}, torques, of_joints) == @{P}_OK, "torques", "OK", k);
    const double power = product(torques, 1, of_found, 1, &size) - product(of_joints, 1, rates, 1, &other);
    expect(fabs(power) <= @{jacobian_bound} * size, "torques", "power", k);
}

/* Second derivatives; the inverse Jacobian against the Jacobian; that joints and found coordinates have the same kinetic energy; that a
 * found torque, and a rate, at its limit has one joint at its own, and none beyond. */
static void derivatives_of(int k)
{
@{configuration_of_k}
    @{p}_real own[N];
    @{p}_real jacobian[N * N];
    @{p}_real inverse[N * N];
    @{p}_real inertia[N * N];
    @{p}_real again[N * N];
    @{p}_real second[N * N * N];
    @{p}_real torques[N];
    @{p}_real rates[N];
    double most = 1.0;
    double size;
    for (int i = 0; i < N; ++i) {
        own[i] = (@{p}_real)(1 + i);
    }
    expect(@{p}_jacobian(@{configuration}, jacobian) == @{P}_OK, "jacobian", "OK", k);
    expect(@{p}_inverse_jacobian(@{configuration}, inverse) == @{P}_OK, "inverse_jacobian", "OK", k);
    expect(@{p}_second(@{configuration}, NULL, second) == @{P}_OK, "second", "without a jacobian", k);
    expect(@{p}_second(@{configuration}, again, second) == @{P}_OK, "second", "OK", k);
    expect(@{p}_inertia(@{configuration}, own, inertia) == @{P}_OK, "inertia", "OK", k);
    expect(@{p}_torque_limits(@{configuration}, own, torques) == @{P}_OK, "torque_limits", "OK", k);
    expect(@{p}_rate_limits(@{configuration}, own, rates) == @{P}_OK, "rate_limits", "OK", k);
    for (int i = 0; i < N * N * N; ++i) {
        most = fmax(most, fabs((double)@{p}_vector_seconds[k][i]));
    }
    for (int i = 0; i < N * N * N; ++i) {
        const double off = (double)second[i] - (double)@{p}_vector_seconds[k][i];
        expect(fabs(off) <= 10.0 * @{jacobian_bound} * most, "second", "entry", i);
    }
    for (int i = 0; i < N; ++i) {
        const @{p}_real *const row = &jacobian[N * i];
        double torque = 0.0;
        double rate = 0.0;
        for (int j = 0; j < N; ++j) {
            const double wanted = (i == j) ? 1.0 : 0.0;
            const double one = product(row, 1, &inverse[j], N, &size);
            expect(fabs(one - wanted) <= 10.0 * @{jacobian_bound} * size, "inverse_jacobian", "entry", k);
            /* the inertia times a column of the Jacobian is that of the joint times one of the inverse */
            const double there = product(&inertia[N * i], 1, &jacobian[j], N, &size);
            const double here = (double)own[j] * (double)inverse[N * j + i];
            expect(fabs(there - here) <= 10.0 * @{jacobian_bound} * size, "inertia", "entry", k);
            expect(again[N * i + j] == row[j], "second", "jacobian", k);
            torque = fmax(torque, fabs((double)row[j] * (double)torques[i]) / (double)own[j]);
            rate = fmax(rate, fabs((double)inverse[N * j + i] * (double)rates[i]) / (double)own[j]);
        }
        expect(fabs(torque - 1.0) <= @{jacobian_bound}, "torque_limits", "torque at its limit", i);
        expect(fabs(rate - 1.0) <= @{jacobian_bound}, "rate_limits", "rate at its limit", i);
    }
}
