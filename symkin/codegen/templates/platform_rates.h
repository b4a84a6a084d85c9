
/* Joint rates of a twist (velocity of the platform's origin, angular velocity) at a pose. Speeds above @{fastest} are
 * @{P}_OUT_OF_RANGE. */
@{p}_status @{p}_rates(@{gpd}const @{p}_pose *pose, const @{p}_real twist[6], @{p}_real rates[@{P}_JOINTS]);

/* The twist of joint rates at a pose; @{P}_SINGULAR where they do not decide it. */
@{p}_status @{p}_twist(@{gpd}const @{p}_pose *pose, const @{p}_real rates[@{P}_JOINTS], @{p}_real twist[6]);

/* The largest factor, 0 to 1, by which a twist keeps every joint rate within its limit (0 or more, in @{unit} or radians for each unit
 * of time). */
@{p}_status @{p}_feed(@{gpd}const @{p}_pose *pose, const @{p}_real twist[6], const @{p}_real rate_limits[@{P}_JOINTS], @{p}_real *feed);
