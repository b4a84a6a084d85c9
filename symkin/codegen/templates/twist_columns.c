/* Minus the derivative of the limb's rows by the platform's twist, row by row: the right-hand sides of the joint rates. */
static void @{k}_twist_columns(@{gp}const @{k}_work *w, @{real} sides[@{count}])
{
@{use}
@{sides}
}

