static void @{k}_rows(@{gp}@{k}_work *w)
{
@{use}
@{rows}
}

/* Root of the sum of the squared rows, as a length: no row is further from zero. */
static @{SHARED} @{real} @{k}_residual(const @{k}_work *w)
{
@{residual}
}

/* Puts the step on; its squared length. */
static @{real} @{k}_move(@{gp}@{k}_work *w)
{
@{use}
@{move}
}

/* Known values aimed at@{aimed}. */
static @{SHARED} void @{k}_target(@{gp}@{k}_work *w, const @{real} to[@{nto}]@{part})
{
@{use}
@{target}
}

