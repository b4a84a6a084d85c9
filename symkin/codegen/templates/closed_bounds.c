/* Bounds how a joint's speed changes, by less than curved speed^2 + 2 crossed speed + own; its speed is its way but for half of that. */
static void @{k}_bounds(@{k}_work *w, int joint, @{real} curved, @{real} crossed, @{real} own)
{
    const @{real} twice = @{two} * crossed;
    const @{real} left = @{one} - twice;
    const @{real} rest = w->way[joint] + own;
    @{real} speed = w->speed[joint];
    if ((left > @{zero}) && (@{four} * curved * rest < @{nearly_one} * left * left)) {
        const @{real} stays = @{two} * rest / left;
        speed = (stays < speed) ? stays : speed;
    }
    for (int i = 0; i < 2; ++i) {
        const @{real} nearer = w->way[joint] + @{half} * (own + speed * (twice + curved * speed));
        speed = (nearer < speed) ? nearer : speed;
    }
    w->speed[joint] = speed;
    w->change[joint] = own + speed * (twice + curved * speed);
}

