#define @{P}_FOUND (@{nq})
#define @{P}_TRACK_LIMIT ((@{p}_real)@{track_limit}) /* @{unit} */

/* The found values that the machine reaches from `guess` when its joints move in a straight line from their values at the guess to the
 * given ones, each point of it real and regular; where that is not assured, @{P}_WRONG_BRANCH. Angles are near the guess's, not
 * wrapped. @{passive_note} */
@{p}_status @{p}_direct(const @{p}_config *config, const @{p}_real joints[@{P}_JOINTS], const @{p}_real guess[@{P}_FOUND],
    @{p}_real found[@{P}_FOUND], @{p}_info *info);

/* The other way: the joints that the machine reaches from `guess` when the found coordinates move in a straight line from their values
 * at the guess to the given ones. */
@{p}_status @{p}_inverse(const @{p}_config *config, const @{p}_real found[@{P}_FOUND], const @{p}_real guess[@{P}_JOINTS],
    @{p}_real joints[@{P}_JOINTS], @{p}_info *info);

/* For servo loops: one step from the last found values to those of the joints, and from the last joints to those of the found values.
 * info->residual is the predicted error: up to @{P}_TRACK_LIMIT another call with the same values brings it below the tolerance;
 * beyond it, and where a step is not small (@{P}_WRONG_BRANCH), call the function above. No line is checked. */
@{p}_status @{p}_track(const @{p}_real joints[@{P}_JOINTS], @{p}_real found[@{P}_FOUND], @{p}_info *info);
@{p}_status @{p}_track_inverse(const @{p}_real found[@{P}_FOUND], @{p}_real joints[@{P}_JOINTS], @{p}_info *info);

/* Row-major @{nq} x @{nq}: found rates = jacobian * joint rates, where joints and found belong together. */
@{p}_status @{p}_jacobian(const @{p}_real joints[@{P}_JOINTS], const @{p}_real found[@{P}_FOUND],
    @{p}_real jacobian[@{P}_FOUND * @{P}_JOINTS]);

/* found_rates = jacobian * joint_rates. */
@{p}_status @{p}_rates(const @{p}_real joints[@{P}_JOINTS], const @{p}_real found[@{P}_FOUND], const @{p}_real joint_rates[@{P}_JOINTS],
    @{p}_real found_rates[@{P}_FOUND]);

/* joint_torques = transposed jacobian * found_torques: the joints' torques (of slides, forces) that hold those of the found ones. */
@{p}_status @{p}_torques(const @{p}_real joints[@{P}_JOINTS], const @{p}_real found[@{P}_FOUND], const @{p}_real found_torques[@{P}_FOUND],
    @{p}_real joint_torques[@{P}_JOINTS]);

/* joint rates = inverse_jacobian * found rates. */
@{p}_status @{p}_inverse_jacobian(const @{p}_real joints[@{P}_JOINTS], const @{p}_real found[@{P}_FOUND],
    @{p}_real inverse_jacobian[@{P}_JOINTS * @{P}_FOUND]);

/* The Jacobian, which may be NULL, and second[(i * @{P}_JOINTS + j) * @{P}_JOINTS + k], the second derivative of found i by joints j and k:
 * found accelerations = jacobian * joint accelerations + sum of second * joint_rates[j] * joint_rates[k]. */
@{p}_status @{p}_second(const @{p}_real joints[@{P}_JOINTS], const @{p}_real found[@{P}_FOUND],
    @{p}_real jacobian[@{P}_FOUND * @{P}_JOINTS], @{p}_real second[@{P}_FOUND * @{P}_JOINTS * @{P}_JOINTS]);

/* Row-major: what the joints' inertias (of slides, masses) are at the found coordinates, G^T joint_inertias G with the inverse Jacobian
 * G. */
@{p}_status @{p}_inertia(const @{p}_real joints[@{P}_JOINTS], const @{p}_real found[@{P}_FOUND],
    const @{p}_real joint_inertias[@{P}_JOINTS], @{p}_real inertia[@{P}_FOUND * @{P}_FOUND]);

/* The largest torque, and the largest rate, of each found coordinate alone, the others without any, for which no joint is beyond its
 * own; @{largest} where no joint bounds it. */
@{p}_status @{p}_torque_limits(const @{p}_real joints[@{P}_JOINTS], const @{p}_real found[@{P}_FOUND],
    const @{p}_real joint_limits[@{P}_JOINTS], @{p}_real found_limits[@{P}_FOUND]);
@{p}_status @{p}_rate_limits(const @{p}_real joints[@{P}_JOINTS], const @{p}_real found[@{P}_FOUND],
    const @{p}_real joint_limits[@{P}_JOINTS], @{p}_real found_limits[@{P}_FOUND]);
