@table
name_direct_work w;
name_real rows[36];
name_real shortest = HUGE_VAL;
@state
name_direct_rows(GEOMETRY &w);
EACH(i, 6) {
    const name_real *const d = &w.d[3 * i];
    name_real *const row = &rows[6 * i];
    @towards
    const name_real squared = DOT3(d, d);
    const name_real inverse = 1.0 / sqrt((squared > 0.0) ? squared : 1.0);
    shortest = (squared < shortest) ? squared : shortest;
    row[0] = d[0] * inverse;
    row[1] = d[1] * inverse;
    row[2] = d[2] * inverse;
    row[3] = aside * row[2] - up * row[1];
    row[4] = up * row[0] - forth * row[2];
    row[5] = forth * row[1] - aside * row[0];
}
