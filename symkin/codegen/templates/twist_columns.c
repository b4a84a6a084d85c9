/* Minus the derivative of the limb's rows by the platform's twist, row by row: the right-hand sides of the joint rates. */
static void solver_twist_columns(@{gp}const solver_work *w, name_real sides[@{count}])
{
@{use}
    @{sides}
}

