/* Bounds how a joint's speed changes, by less than curved speed^2 + 2 crossed speed + own; its speed is its way but for half of that. */
static void solver_bounds(solver_work *w, int joint, name_real curved, name_real crossed, name_real own)
{
    const name_real twice = 2.0 * crossed;
    const name_real left = 1.0 - twice;
    const name_real rest = w->way[joint] + own;
    name_real speed = w->speed[joint];
    if ((left > 0.0) && (4.0 * curved * rest < @nearly_one * left * left)) {
        const name_real stays = 2.0 * rest / left;
        speed = (stays < speed) ? stays : speed;
    }
    EACH(i, 2) {
        const name_real nearer = w->way[joint] + 0.5 * (own + speed * (twice + curved * speed));
        speed = (nearer < speed) ? nearer : speed;
    }
    w->speed[joint] = speed;
    w->change[joint] = own + speed * (twice + curved * speed);
}

