/* The largest factor, up to 1, by which a twist keeps all joint rates within their limits. */
name_status name_feed(GEOMETRY_GIVEN @at, const name_real twist[6], const name_real rate_limits[@nq], name_real *feed)
{
    name_real rates[@nq];
    name_status status = name_check_finite(rate_limits, @nq, name_rates(GEOMETRY @of, twist, rates@no_info));
    name_real most = 1.0;
    EACH_WHILE(i, @nq, (status == NAME_OK)) {
        const name_real rate = fabs(rates[i]);
        if (rate_limits[i] < 0.0) {
            status = NAME_OUT_OF_RANGE;
        } else if (rate * most > rate_limits[i]) {
            most = rate_limits[i] / rate;
        } else {
            /* within its limit */
        }
    }
    IF_OK {
        *feed = most;
    }
    return status;
}

