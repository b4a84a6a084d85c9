/* The rows f(x; k) into w->f, and what the matrix shares with them. */
static void @{k}_rows(@{gp}@{k}_work *w)
{
@{use}
@{rows}
}

/* Norm of the rows in w->f as a length: no row is further from zero. */
static @{SHARED} @{real} @{k}_residual(const @{k}_work *w)
{
@{residual}
}

/* Adds the step in w->f to the state: lengths and joint values are added to, quaternions are turned. Returns the squared
 * length of the step, angles times the size. */
static @{real} @{k}_apply_step(@{gp}@{k}_work *w)
{
@{use}
@{move}
}

