/* The sum of products of N numbers each, which stand so far apart, and in *size of their magnitudes. */
static double product(const name_real *a, int apart, const name_real *b, int from, double *size)
{
    double sum = 0.0;
    *size = 1.0;
    EACH(i, N) {
        const double part = (double)a[apart * i] * (double)b[from * i];
        sum += part;
        *size += fabs(part);
    }
    return sum;
}

/* The law of virtual power: joint torques on joint rates do what found torques do on found rates. Second derivatives; the inverse
 * Jacobian against the Jacobian; that joints and found coordinates have the same kinetic energy; that a found torque, and a rate, at its
 * limit has one joint at its own, and none beyond. */
static void derivatives_of(int k)
{
    @configuration_of_k
    name_real own[N];
    name_real speeds[N];
    name_real jacobian[N * N];
    name_real inverse[N * N];
    name_real inertia[N * N];
    name_real again[N * N];
    name_real second[N * N * N];
    name_real torques[N];
    name_real rates[N];
    double most = 1.0;
    double off = 0.0;
    double size;
    double other;
    EACH(i, N) {
        own[i] = (name_real)(1 + i);
        speeds[i] = (name_real)(2 - i);
    }
    ASK(rates, (@configuration, speeds, rates))
    ASK(torques, (@configuration, own, torques))
    const double power = product(own, 1, rates, 1, &size) - product(torques, 1, speeds, 1, &other);
    expect(fabs(power) <= @jacobian_bound * size, "power", k);
    ASK(jacobian, (@configuration, jacobian))
    ASK(inverse_jacobian, (@configuration, inverse))
    ASK(second, (@configuration, NULL, second))
    ASK(second, (@configuration, again, second))
    expect(memcmp(again, jacobian, sizeof again) == 0, "jacobian", k);
    EACH(i, N * N * N) {
        const double wanted = (double)name_vector_seconds[k][i];
        most = larger(most, fabs(wanted));
        off = larger(off, fabs((double)second[i] - wanted));
    }
    expect(off <= 10.0 * @jacobian_bound * most, "entry", k);
    ASK(inertia, (@configuration, own, inertia))
    ASK(torque_limits, (@configuration, own, torques))
    ASK(rate_limits, (@configuration, own, rates))
    EACH(i, N) {
        const name_real *const row = &jacobian[N * i];
        double torque = 0.0;
        double rate = 0.0;
        EACH(j, N) {
            const double one = product(row, 1, &inverse[j], N, &size) - ((i == j) ? 1.0 : 0.0);
            expect(fabs(one) <= 10.0 * @jacobian_bound * size, "the Jacobian times its inverse", k);
            /* the inertia times a column of the Jacobian is that of the joint times one of the inverse */
            const double there = product(&inertia[N * i], 1, &jacobian[j], N, &size);
            const double here = (double)own[j] * (double)inverse[N * j + i];
            expect(fabs(there - here) <= 10.0 * @jacobian_bound * size, "inertia", k);
            torque = larger(torque, fabs((double)row[j] * (double)torques[i]) / (double)own[j]);
            rate = larger(rate, fabs((double)inverse[N * j + i] * (double)rates[i]) / (double)own[j]);
        }
        expect(fabs(torque - 1.0) <= @jacobian_bound, "torque at its limit", i);
        expect(fabs(rate - 1.0) <= @jacobian_bound, "rate at its limit", i);
    }
}
