for (int i = 0; (i < @nj) && (jacobian != NULL); ++i) {
    jacobian[i] = rates[i];
}
for (int i = 0; i < @nq; ++i) {
    for (int k = 0; k < @nq; ++k) {
        for (int j = 0; j <= k; ++j) {
            second[@nj * i + @nq * j + k] = rates[@nj + @pairs * i + (k * (k + 1)) / 2 + j];
            second[@nj * i + @nq * k + j] = second[@nj * i + @nq * j + k];
        }
    }
}
