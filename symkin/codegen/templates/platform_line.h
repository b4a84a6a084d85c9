
/* Whether the joints keep their limits while the platform goes from one pose to another in a straight line: its position linearly, its
 * quaternion as q0 + t (q1 - q0) over its length, the shortest turn. @{P}_OK: they do, at all points; by bounds, not by samples.
 * @{P}_OUT_OF_RANGE: the joint info->joint leaves its limits, or comes so near that this is not decided (@{P}_JOINTS: a pose cannot be taken).
 * Of a config max_iterations is read: the parts that are looked at, info->iterations. info->residual is 0 with @{P}_OK.
 * Singularities are not looked for. */
@{p}_status @{p}_line(@{gpd}const @{p}_config *config, const @{p}_pose *from, const @{p}_pose *to, @{p}_info *info);
