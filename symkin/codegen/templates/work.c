/* Work space of solver_newton, which solves the rows f(x; k) = 0 for the state x.
@meaning
 */
typedef struct {
    name_real x[@ns]; /* state */
    @x0; /* state at the part of the line that is done, to which a failed try returns */
@at
    name_real k[@nk]; /* known values aimed at */
    name_real f[@m]; /* rows */
@shared
    name_real a[@na]; /* matrix -df/dstep, row by row; then @factors in its place */
@r
@sides
    name_real spread; /* sum of the squared reciprocals of the scaled pivots: large near a singularity */
@members
    uint8_t order[@n]; /* rows exchanged by the pivoting fallback */
    bool pivoted; /* whether w->a holds the factors of the fallback */
} solver_work;

