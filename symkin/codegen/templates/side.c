/* The sign of the determinant beside the one where the line began, 0 where it is not decided. Of more rows than unknowns it is that of
 * Q0^T Q, Q0 the factors of the part that is done: where branches meet a column of the matrix goes through 0 and comes back reversed.
 * keep: these factors are those of the part that is done. */
static int solver_side(solver_work *w, bool keep)
{
    TABLE(least, @n, @least_sides)
    name_real d[@n * @n];
    uint8_t order[@n];
    int side = 1;
    if (w->side != 0) {
        EACH(i, @n) {
            EACH(j, @n) {
                d[@n * i + j] = 0.0;
                EACH(row, @m) {
                    d[@n * i + j] += w->q[@n * row + i] * w->a[@n * row + j];
                }
            }
        }
        const int turned = name_lu(d, order, least, @n);
        side = (w->side < 0) ? -turned : turned;
    }
    if (keep) {
        COPY(w->q, w->a, @na)
        w->side = (int8_t)side;
    }
    return side;
}

