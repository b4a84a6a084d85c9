/* @{speeds_law} The feed keeps the limits, and one joint reaches its own where it is below 1. */
static void speeds_of(int k)
{
@nominal
    @configuration_of_k
    name_real rates[N];
    name_real again[N];
    name_real twist[6] = { @zero };
    name_real limits[N];
    name_real feed = @zero;
    EACH(i, N) {
        rates[i] = (name_real)(((i % 3 == 0) ? 1.0 : (i % 3 == 1) ? -0.5 : 0.25) * (@speed_unit));
    }
    ASK(twist, (@ga@configuration, rates, twist))
    ASK(rates, (@ga@configuration, twist, again@no_info))
    @speeds_compared
    EACH(part, 2) {
        const double limit = (part == 0) ? 0.125 : 4.0;
        double largest = 0.0;
        EACH(i, N) {
            limits[i] = (name_real)(limit * (@speed_unit));
        }
        ASK(feed, (@ga@configuration, twist, limits, &feed))
        EACH(i, N) {
            largest = larger(largest, fabs((double)feed * (double)again[i]) / (@speed_unit));
        }
        expect(largest <= limit * (1.0 + 1e-5), "keeps limits", k);
        expect((feed == @one) || (largest >= limit * (1.0 - 1e-5)), "reaches a limit", k);
    }
    expect(feed == @one, "no need for one", k);
}

