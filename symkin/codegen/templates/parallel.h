@{geometry}
/* The pose that the machine reaches from `guess` when its joints move in a straight line from the guess's joint values to
 * the given ones without meeting a singularity; where that is not assured, @{P}_WRONG_BRANCH. The guess need not fit any
 * joint values that were read: an error of it moves the beginning of the line by as much. @{guess_precision} */
@{p}_status @{p}_direct(@{gpd}const @{p}_config *config, const @{p}_real joints[@{P}_JOINTS], const @{p}_pose *guess, @{p}_pose *pose,
    @{p}_info *info);

/* For servo loops: @{track_words} */
#define @{P}_TRACK_LIMIT ((@{p}_real)@{track_limit}) /* @{unit} */
@{p}_status @{p}_track(@{gpd}const @{p}_real joints[@{P}_JOINTS], @{p}_pose *pose, @{p}_info *info);

/* Joint values of a pose. */
@{p}_status @{p}_inverse(@{gpd}const @{p}_pose *pose, @{p}_real joints[@{P}_JOINTS]);

/* Row-major @{nq} x 6: joint rates = jacobian * (velocity of the platform's origin, angular velocity). */
@{p}_status @{p}_jacobian(@{gpd}const @{p}_pose *pose, @{p}_real jacobian[@{P}_JOINTS * 6]);
@{line}
@{speeds}
