/* Second derivatives of the rows along the motions of two joints each: pair k (k + 1) / 2 + j is of the joints j <= k, of which each
 * moves the state by its steps. */
static void name_joint_bends(const solver_work *w, const name_real steps[@{nsteps}], name_real sides[@{nbends}])
{
    (void)w;
    (void)steps;
    @{bends}
}

