/* Joint values at the state, into w->k. */
static @{SHARED} void @{p}_rod_values(@{gp}@{p}_direct_work *w)
{
@{lines}
}

