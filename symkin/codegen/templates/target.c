/* Sets w->k, the known values aimed at@{aimed}. */
static @{SHARED} void @{k}_set_target(@{gp}@{k}_work *w, const @{real} to[@{nto}]@{part})
{
@{use}
@{target}
}

