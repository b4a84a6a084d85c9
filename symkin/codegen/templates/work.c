typedef struct {
    @{real} x[@{ns}]; /* state */
    @{real} x0[@{ns}]; /* state at the part of the line that is done */
@{at}
    @{real} k[@{nk}]; /* known values aimed at, as the rows take them */
    @{real} f[@{most}]; /* rows, then the step */
@{shared}
    @{real} a[@{na}]; /* matrix, then its factors */
@{r}
    @{real} spread; /* sum of the squared reciprocals of the scaled pivots */
@{guess}
    uint8_t order[@{n}]; /* rows exchanged by the fallback */
    bool pivoted;
} @{k}_work;

