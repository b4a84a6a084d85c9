/* Whether no guard can reach zero between the values w->left and w->guard, on a part of the line of which `change` are the squares of
 * the known values' changes: a guard bends by no more than its weights times these allow (README.md). */
static bool solver_keeps(solver_work *w, const name_real change[@nto])
{
    @keep_lines
}

/* Follows the line of known values from `at`, where the guards are w->left, to `to` in parts that are kept, and are cut where they are
 * not. */
static @walks name_status solver_walk(solver_work *w, const name_real at[@nat], const name_real to[@nat], @{aimed}unsigned int most,
    unsigned int *count)
{
    name_real way2[@nways];
    name_real change[@nto];
    name_real done = 0.0;
    name_real part = @first_part;
    bool refused = true;
    name_status status = NAME_MAX_ITERATIONS;
@walk_members
@ways
    while ((status == NAME_MAX_ITERATIONS) && (*count < most)) {
        const name_real next = done + part;
        const name_real end = (next < 0.9999) ? next : 1.0;
        const name_real share = end - done;
        const name_real share2 = share * share;
        bool above = true;
        EACH(i, @nways) {
            change[i] = share2 * way2[i];
        }
        @aim
        ++*count;
        @not_measured
@hold_guards
        if (!above) {
            /* a point of the line without a configuration, or a singular one */
            status = @unreached;
        } else if (solver_keeps(w, change)@and_follows) {
            @take
            EACH(j, @ng) {
                w->left[j] = w->guard[j];
            }
            done = end;
            part = refused ? part : (@longer);
            refused = false;
            if (done >= 1.0) {
                status = NAME_OK;
            }
        } else {
            @shorter
            refused = true;
            if (part < @least_part) {
                status = @refused;
            }
        }
    }
    return status;
}

