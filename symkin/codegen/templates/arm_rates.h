
/* Joint rates whose twist is next to the given one (velocity of the tool's origin, angular velocity): of the shortest, and damped
 * where the arm is near a singularity, that is where info->min_pivot is below @{damped_below}. info->residual is how far the twist
 * of these rates is from the given one (@{unit} for each unit of time, angles times the size): a loop that must
 * keep to its path slows down or stops by it. Speeds above @{fastest} are @{P}_OUT_OF_RANGE. */
@{p}_status @{p}_rates(@{gpd}const @{p}_real joints[@{P}_JOINTS], const @{p}_real twist[6], @{p}_real rates[@{P}_JOINTS],
    @{p}_info *info);

/* The twist of joint rates. */
@{p}_status @{p}_twist(@{gpd}const @{p}_real joints[@{P}_JOINTS], const @{p}_real rates[@{P}_JOINTS], @{p}_real twist[6]);

/* The largest factor, 0 to 1, by which a twist keeps the rates of @{p}_rates within their limits (0 or more, in @{unit} or radians
 * for each unit of time). */
@{p}_status @{p}_feed(@{gpd}const @{p}_real joints[@{P}_JOINTS], const @{p}_real twist[6], const @{p}_real rate_limits[@{P}_JOINTS],
    @{p}_real *feed);

/* For a control loop: one damped step from the last joint values (joints) towards the pose, which becomes the next ones. It goes on
 * through and beside singularities, where the arm cannot follow every pose: @{P}_OK says that the joint values are
 * within their ranges, and info->residual how far their tool pose is from the given one, as measured (@{unit}, angles times the
 * size). While it is below @{P}_TRACK_LIMIT the next step reaches an unmoved pose; farther away steps are cut to
 * @{most_turn} rad (slides: of the size). It never makes the error larger. */
#define @{P}_TRACK_LIMIT ((@{p}_real)@{track_limit}) /* @{unit} */
@{p}_status @{p}_track(@{gpd}const @{p}_pose *pose, @{p}_real joints[@{P}_JOINTS], @{p}_info *info);
