/* The sum of products of N numbers each, which stand so far apart, and in *size of their magnitudes. */
static double product(const name_real *a, int apart, const name_real *b, int from, double *size)
{
    double sum = 0.0;
    *size = 1.0;
    EACH(i, N) {
        sum += (double)a[apart * i] * (double)b[from * i];
        *size += fabs((double)a[apart * i] * (double)b[from * i]);
    }
    return sum;
}

/* The law of virtual power: joint torques on joint rates do what found torques do on found rates. */
static void power_of(int k)
{
    @configuration_of_k
    name_real torques[N];
    name_real rates[N];
    name_real of_found[N];
    name_real of_joints[N];
    double size;
    double other;
    EACH(i, N) {
        torques[i] = (name_real)(1 + i);
        rates[i] = (name_real)(2 - i);
    }
    expect(name_rates(@configuration, rates, of_found) == NAME_OK, "rates", "OK", k);
    expect(name_torques(@configuration, torques, of_joints) == NAME_OK, "torques", "OK", k);
    const double power = product(torques, 1, of_found, 1, &size) - product(of_joints, 1, rates, 1, &other);
    expect(fabs(power) <= @jacobian_bound * size, "torques", "power", k);
}

/* Second derivatives; the inverse Jacobian against the Jacobian; that joints and found coordinates have the same kinetic energy; that a
 * found torque, and a rate, at its limit has one joint at its own, and none beyond. */
static void derivatives_of(int k)
{
    @configuration_of_k
    name_real own[N];
    name_real jacobian[N * N];
    name_real inverse[N * N];
    name_real inertia[N * N];
    name_real again[N * N];
    name_real second[N * N * N];
    name_real torques[N];
    name_real rates[N];
    double most = 1.0;
    double size;
    EACH(i, N) {
        own[i] = (name_real)(1 + i);
    }
    expect(name_jacobian(@configuration, jacobian) == NAME_OK, "jacobian", "OK", k);
    expect(name_inverse_jacobian(@configuration, inverse) == NAME_OK, "inverse_jacobian", "OK", k);
    expect(name_second(@configuration, NULL, second) == NAME_OK, "second", "without a jacobian", k);
    expect(name_second(@configuration, again, second) == NAME_OK, "second", "OK", k);
    expect(name_inertia(@configuration, own, inertia) == NAME_OK, "inertia", "OK", k);
    expect(name_torque_limits(@configuration, own, torques) == NAME_OK, "torque_limits", "OK", k);
    expect(name_rate_limits(@configuration, own, rates) == NAME_OK, "rate_limits", "OK", k);
    EACH(i, N * N * N) {
        most = fmax(most, fabs((double)name_vector_seconds[k][i]));
    }
    EACH(i, N * N * N) {
        const double off = (double)second[i] - (double)name_vector_seconds[k][i];
        expect(fabs(off) <= 10.0 * @jacobian_bound * most, "second", "entry", i);
    }
    EACH(i, N) {
        const name_real *const row = &jacobian[N * i];
        double torque = 0.0;
        double rate = 0.0;
        EACH(j, N) {
            const double wanted = (i == j) ? 1.0 : 0.0;
            const double one = product(row, 1, &inverse[j], N, &size);
            expect(fabs(one - wanted) <= 10.0 * @jacobian_bound * size, "inverse_jacobian", "entry", k);
            /* the inertia times a column of the Jacobian is that of the joint times one of the inverse */
            const double there = product(&inertia[N * i], 1, &jacobian[j], N, &size);
            const double here = (double)own[j] * (double)inverse[N * j + i];
            expect(fabs(there - here) <= 10.0 * @jacobian_bound * size, "inertia", "entry", k);
            expect(again[N * i + j] == row[j], "second", "jacobian", k);
            torque = fmax(torque, fabs((double)row[j] * (double)torques[i]) / (double)own[j]);
            rate = fmax(rate, fabs((double)inverse[N * j + i] * (double)rates[i]) / (double)own[j]);
        }
        expect(fabs(torque - 1.0) <= @jacobian_bound, "torque_limits", "torque at its limit", i);
        expect(fabs(rate - 1.0) <= @jacobian_bound, "rate_limits", "rate at its limit", i);
    }
}
