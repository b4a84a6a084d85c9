/* The law of virtual power: joint torques on joint rates do what found torques do on found rates. */
static void power_of(int k)
{
@{configuration_of_k}
    @{p}_real torques[N];
    @{p}_real rates[N];
    @{p}_real of_found[N];
    @{p}_real of_joints[N];
    double power = 0.0;
    double size = 1.0;
    for (int i = 0; i < N; ++i) {
        torques[i] = (@{p}_real)(1 + i);
        rates[i] = (@{p}_real)(2 - i);
    }
    expect(@{p}_rates(@{configuration}, rates, of_found) == @{P}_OK, "rates", "OK", k);
    expect(@{p}_torques(@{configuration}, torques, of_joints) == @{P}_OK, "torques", "OK", k);
    for (int i = 0; i < N; ++i) {
        power += (double)torques[i] * (double)of_found[i] - (double)of_joints[i] * (double)rates[i];
        size += fabs((double)torques[i] * (double)of_found[i]);
    }
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
        double torque = 0.0;
        double rate = 0.0;
        for (int j = 0; j < N; ++j) {
            double one = 0.0;
            double energy = 0.0;
            double scale = 1.0;
            for (int l = 0; l < N; ++l) {
                one += (double)jacobian[N * i + l] * (double)inverse[N * l + j];
                scale += fabs((double)jacobian[N * i + l] * (double)inverse[N * l + j]);
                for (int h = 0; h < N; ++h) {
                    energy += (double)jacobian[N * l + i] * (double)inertia[N * l + h] * (double)jacobian[N * h + j];
                    scale += fabs((double)jacobian[N * l + i] * (double)inertia[N * l + h] * (double)jacobian[N * h + j]);
                }
            }
            expect(again[N * i + j] == jacobian[N * i + j], "second", "jacobian", k);
            expect(fabs(one - ((i == j) ? 1.0 : 0.0)) <= 10.0 * @{jacobian_bound} * scale, "inverse_jacobian", "entry", k);
            expect(fabs(energy - ((i == j) ? (double)own[i] : 0.0)) <= 10.0 * @{jacobian_bound} * scale, "inertia", "entry", k);
            torque = fmax(torque, fabs((double)jacobian[N * i + j] * (double)torques[i]) / (double)own[j]);
            rate = fmax(rate, fabs((double)inverse[N * j + i] * (double)rates[i]) / (double)own[j]);
        }
        expect(fabs(torque - 1.0) <= @{jacobian_bound}, "torque_limits", "torque at its limit", i);
        expect(fabs(rate - 1.0) <= @{jacobian_bound}, "rate_limits", "rate at its limit", i);
    }
}

