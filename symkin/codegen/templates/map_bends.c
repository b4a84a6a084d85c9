/* Second derivatives of the rows along the motions of two joints each: pair k (k + 1) / 2 + j is of the joints j <= k, of which each
 * moves the state by its steps. */
static void @{p}_joint_bends(const @{k}_work *w, const @{real} steps[@{nsteps}], @{real} sides[@{nbends}])
{
    (void)w;
    (void)steps;
@{bends}
}

