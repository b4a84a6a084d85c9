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
    const name_real w = to[3] * x[3] + to[4] * x[4] + to[5] * x[5] + to[6] * x[6];
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
    static const name_real row_scale[6] = { @row_scales };
    @column_scale
    name_real a[6][@nq];
    name_real g[@nm][@nm]; /* upper triangle: factors; below: the normal equations */
    name_real diagonal[@nm];
    name_real right[@nm];
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
        right[i] = @right_start;
        @right
        EACH_FROM(j, i, @nm) {
            name_real sum = 0.0;
            EACH(k, @inner) {
                sum += @product;
            }
            g[j][i] = sum;
        }
        diagonal[i] = g[i][i];
        mean += diagonal[i];
    }
    mean *= @per_count;
    for (int round = 0; (round < 2) && ((round == 0) || (smallest < @damped_pivot)); ++round) {
        uint8_t order[@nm];
        name_real r[@nm];
        name_real over[@nm];
        EACH(i, @nm) {
            order[i] = (uint8_t)i;
            r[i] = right[i];
            g[i][i] = diagonal[i] + raised;
            EACH_FROM(j, i + 1, @nm) {
                g[i][j] = g[j][i];
            }
        }
        /* factors, the largest diagonal entry first, with the right side beside them */
        bool whole = true;
        EACH_WHILE(c, @nm, whole) {
            int best = c;
            EACH_FROM(i, c + 1, @nm) {
                best = (g[i][i] > g[best][best]) ? i : best;
            }
            if (best != c) {
                const uint8_t name = order[c];
                const name_real side = r[c];
                order[c] = order[best];
                order[best] = name;
                r[c] = r[best];
                r[best] = side;
                EACH(k, @nm) {
                    if ((k != c) && (k != best)) {
                        name_real *const one = (k < c) ? &g[k][c] : &g[c][k];
                        name_real *const other = (k < best) ? &g[k][best] : &g[best][k];
                        const name_real t = *one;
                        *one = *other;
                        *other = t;
                    }
                }
                const name_real first = g[c][c];
                g[c][c] = g[best][best];
                g[best][best] = first;
            }
            whole = g[c][c] > @least_pivot * mean;
            over[c] = whole ? (1.0 / g[c][c]) : 0.0;
            for (int i = c + 1; (i < @nm) && whole; ++i) {
                const name_real factor = g[c][i] * over[c];
                EACH_FROM(j, i, @nm) {
                    g[i][j] -= factor * g[c][j];
                }
                r[i] -= factor * r[c];
            }
        }
        if (round == 0) {
            smallest = whole ? (g[@last][@last] / mean) : 0.0;
            raised = mean * (@damped_pivot - smallest);
        }
        /* back substitution; without a whole set of factors the next round follows */
        for (int i = @last; (i >= 0) && whole; --i) {
            EACH_FROM(j, i + 1, @nm) {
                r[i] -= g[i][j] * r[j];
            }
            r[i] *= over[i];
        }
        EACH(i, @nq) {
            y[i] = 0.0;
        }
        EACH_WHILE(i, @nm, whole) {
            @back
        }
    }
    @scaled
    return smallest;
}

