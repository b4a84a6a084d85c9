/* Length of a twist or of an error of poses in angles and lengths over the size, as a length. */
static name_real name_length_of(const name_real e[6])
{
    name_real sum = 0.0;
    EACH(i, 6) {
        sum += e[i] * e[i];
    }
    return sqrt(sum) * NAME_SIZE;
}

/* How far the tool pose of @u_what is from `to`: lengths over the size, and twice the vector of the turn's quaternion. Returns
 * its length. */
static name_real name_error_at(GEOMETRY_GIVEN const name_real @u[@n_u], const name_real to[7], name_real e[6])
{
    name_real x[7];
    name_@pose_at(GEOMETRY @u, x);
    const name_real w = QUATERNIONS_DOT(to, x);
    const name_real twice = (w < 0.0) ? -2.0 : 2.0;
    EACH(i, 3) {
        e[i] = (to[i] - x[i]) * @per_size;
    }
    e[3] = twice * (to[4] * x[3] - to[3] * x[4] - to[5] * x[6] + to[6] * x[5]);
    e[4] = twice * (to[5] * x[3] - to[3] * x[5] - to[6] * x[4] + to[4] * x[6]);
    e[5] = twice * (to[6] * x[3] - to[3] * x[6] - to[4] * x[5] + to[5] * x[4]);
    return name_length_of(e);
}

/* Joint rates y (of slides over the size) of least |J y - e| and length, J and e in angles and lengths over the size. Solves the
 * @nm normal equations with exchanges on the diagonal; where their smallest pivot is below @damped_pivot of the mean, the
 * diagonal is raised, the more the smaller it is. Returns that pivot over the mean. */
static name_real name_damped(const name_real jacobian[@nj], const name_real e[6], name_real y[@nq])
{
    TABLE(row_scale, 6, @row_scales)
    @column_scale
    name_real a[6][@nq];
    name_real g[@nm][@nm];
    name_real right[@nm];
    name_real z[@nm];
    bool whole = true;
    name_real smallest = 0.0;
    name_real mean = 0.0;
    name_real raised = 0.0;
    EACH(i, 6) {
        EACH(j, @nq) {
            a[i][j] = jacobian[@nq * i + j] * row_scale[i]@times_column;
        }
    }
    /* the normal equations, which are symmetric */
    EACH(i, @nm) {
        right[i] = @right;
        EACH_FROM(j, i, @nm) {
            g[i][j] = @product;
            g[j][i] = g[i][j];
        }
        mean += g[i][i];
    }
    mean *= @per_count;
    for (int round = 0; (round < 2) && ((round == 0) || (smallest < @damped_pivot)); ++round) {
        uint8_t order[@nm];
        name_real left[@nm]; /* of the diagonal */
        name_real over[@nm];
        name_real row[@nm][@nm]; /* of each step, and its factors; a column each */
        name_real factor[@nm][@nm];
        EACH(i, @nm) {
            order[i] = (uint8_t)i;
            z[i] = right[i];
            left[i] = g[i][i] + raised;
        }
        /* factors, the largest diagonal entry first, with the right side beside them */
        whole = true;
        EACH_WHILE(c, @nm, whole) {
            int best = c;
            EACH_FROM(i, c + 1, @nm) {
                best = (left[order[i]] > left[order[best]]) ? i : best;
            }
            const uint8_t p = order[best];
            order[best] = order[c];
            order[c] = p;
            whole = left[p] > @least_pivot * mean;
            over[c] = whole ? (1.0 / left[p]) : 0.0;
            for (int i = c + 1; (i < @nm) && whole; ++i) {
                const uint8_t j = order[i];
                name_real sum = g[p][j];
                EACH(k, c) {
                    sum -= factor[p][k] * row[j][k];
                }
                row[j][c] = sum;
                factor[j][c] = sum * over[c];
                left[j] -= factor[j][c] * sum;
                z[j] -= factor[j][c] * z[p];
            }
        }
        if (round == 0) {
            smallest = whole ? (left[order[@last]] / mean) : 0.0;
            raised = mean * (@damped_pivot - smallest);
        }
        /* back substitution; without a whole set of factors the next round follows */
        for (int c = @last; (c >= 0) && whole; --c) {
            const uint8_t p = order[c];
            z[p] *= over[c];
            EACH_FROM(i, c + 1, @nm) {
                z[p] -= factor[order[i]][c] * z[order[i]];
            }
        }
    }
    EACH(i, @nq) {
        y[i] = whole ? @back : 0.0;
    }
    return smallest;
}

