/* @{speeds_law} The feed keeps the limits, and one joint reaches its own where it is below 1. */
static void speeds_of(int k)
{
@{nominal}
@{configuration_of_k}
    @{p}_real rates[N];
    @{p}_real again[N];
    @{p}_real twist[6] = { @{zero} };
    @{p}_real limits[N];
    @{p}_real feed = @{zero};
    for (int i = 0; i < N; ++i) {
        rates[i] = (@{p}_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1) ? -0.5 : 0.25) * (@{speed_unit}));
    }
    expect(@{p}_twist(@{ga}@{configuration}, rates, twist) == @{P}_OK, "twist", "OK", k);
    expect(@{p}_rates(@{ga}@{configuration}, twist, again@{no_info}) == @{P}_OK, "rates", "OK", k);
@{speeds_compared}
    for (int part = 0; part < 2; ++part) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        for (int i = 0; i < N; ++i) {
            limits[i] = (@{p}_real)(limit * (@{speed_unit}));
        }
        expect(@{p}_feed(@{ga}@{configuration}, twist, limits, &feed) == @{P}_OK, "feed", "OK", k);
        for (int i = 0; i < N; ++i) {
            largest = fmax(largest, fabs((double)feed * (double)again[i]) / (@{speed_unit}));
        }
        expect(largest <= limit * (1.0 + 1e-5), "feed", "keeps limits", k);
        expect((feed == @{one}) || (largest >= limit * (1.0 - 1e-5)), "feed", "reaches a limit", k);
    }
    expect(feed == @{one}, "feed", "no need for one", k);
}

