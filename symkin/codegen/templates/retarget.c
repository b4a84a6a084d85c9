/* Aims anew at a part of the line from the guess's joint values to the given ones, and puts the state back to the part
 * that is done. The guess's joint values are computed again, which takes less room than to keep them. */
static NAME_COLD void name_direct_retarget(GEOMETRY_GIVEN name_direct_work *w, const name_real to[6], name_real part, name_real done)
{
    const name_real *goal = to;
    (void)name_normalise_pose(GEOMETRY w->guess, w->x);
    if (part < 1.0) {
        /* joint values at the guess into w->k, the part of the line into w->f */
        name_rod_values(GEOMETRY w);
        EACH(i, 6) {
            w->f[i] = w->k[i] + part * (to[i] - w->k[i]);
        }
        goal = w->f;
    }
    name_direct_set_target(GEOMETRY w, goal);
    if (done > 0.0) {
        (void)name_normalise_pose(GEOMETRY &w->x0, w->x);
    }
}

