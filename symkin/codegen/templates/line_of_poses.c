    /* of q and -q, one rotation, the one on the guess's side */
    const name_real cosine = QUATERNIONS_DOT(at, to);
    const name_real side = (cosine < 0.0) ? -1.0 : 1.0;
    name_real move[7];
    way2[0] = 0.0;
    way2[1] = @turn_noise;
    EACH(i, 7) {
        move[i] = ((i < 3) ? to[i] : (side * to[i])) - at[i];
        way2[(i < 3) ? 0 : 1] += move[i] * move[i];
    }
    way2[0] *= @per_size2;
    /* the square of the largest speed of the turn between them, of which they are the chord */
    way2[1] *= 8.0 / (1.0 + (side * cosine));