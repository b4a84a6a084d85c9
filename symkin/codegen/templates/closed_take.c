/* Takes a bend of a part against the most that keeps it; the largest of these shares is what cuts the part, or lets the next one grow. */
static void solver_take(solver_work *w, name_real bend, name_real most)
{
    if (w->kept && (!(bend < most) || (bend * w->most > w->bent * most))) {
        w->bent = bend;
        w->most = most;
    }
    w->kept = w->kept && (bend < most);
}

