@{geometry}
/* Tool pose of joint values; its quaternion has w >= 0. */
@{p}_status @{p}_direct(@{gpd}const @{p}_real joints[@{P}_JOINTS], @{p}_pose *pose);

/* The joint values that the arm reaches from `guess` when its tool moves from the guess's pose to the given one, positions
 * in a straight line and orientations along the shorter arc, without meeting a singularity; where that is not
 * assured, @{P}_WRONG_BRANCH. Angles are near the guess's, not wrapped. Any joint values will do
 * as a guess: an error of them moves the beginning of the line by as much.
@{meaning}
@{line_words}
 */
@{p}_status @{p}_inverse(@{gpd}const @{p}_config *config, const @{p}_pose *pose, const @{p}_real guess[@{P}_JOINTS],
    @{p}_real joints[@{P}_JOINTS], @{p}_info *info);

@{closed}
/* Row-major 6 x @{nq}: (velocity of the tool's origin, angular velocity) = jacobian * joint rates. */
@{p}_status @{p}_jacobian(@{gpd}const @{p}_real joints[@{P}_JOINTS], @{p}_real jacobian[6 * @{P}_JOINTS]);
@{speeds}
