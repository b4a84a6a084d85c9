/* rates are those of the twists that the platform can take */
name_real feasible[MOST];
for (int i = 0; i < 6 * N; ++i) {
    feasible[i] = @zero;
    for (int j = 0; j < 6; ++j) {
        feasible[i] += jacobian[6 * (i / 6) + j] * name_vector_feasible[k][6 * j + i % 6];
    }
}
copy(feasible, jacobian, 6 * N);
