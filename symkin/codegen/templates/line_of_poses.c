    /* of q and -q, one rotation, the one on the guess's side */
    const @{real} cosine = at[3] * to[3] + at[4] * to[4] + at[5] * to[5] + at[6] * to[6];
    const @{real} side = (cosine < @{zero}) ? -@{one} : @{one};
    way2[0] = @{zero};
    /* the square of the largest speed of the turn between them */
    way2[1] = @{sixteen} * ((@{one} - side * cosine) + @{turn_noise}) / (@{one} + side * cosine);
    for (int i = 0; i < 3; ++i) {
        way2[0] += (to[i] - at[i]) * (to[i] - at[i]) * @{per_size2};
    }