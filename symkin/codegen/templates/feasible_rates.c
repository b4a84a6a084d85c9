/* rates are those of the twists that the platform can take */
name_real feasible[MOST];
EACH(i, 6 * N) {
    feasible[i] = @zero;
    EACH(j, 6) {
        feasible[i] += jacobian[6 * (i / 6) + j] * name_vector_feasible[k][6 * j + i % 6];
    }
}
copy(feasible, jacobian, 6 * N);
