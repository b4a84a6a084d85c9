    /* of q and -q, one rotation, the one on the guess's side */
    const @{real} cosine = at[3] * to[3] + at[4] * to[4] + at[5] * to[5] + at[6] * to[6];
    const @{real} side = (cosine < @{zero}) ? -@{one} : @{one};
    way2[0] = @{zero};
    way2[1] = @{eight} * ((@{one} - side * cosine) + @{turn_noise});
    for (int i = 0; i < 3; ++i) {
        way2[0] += (to[i] - at[i]) * (to[i] - at[i]) * @{per_size2};
    }