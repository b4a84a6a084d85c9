EACH_WHILE(i, @nj, (jacobian != NULL)) {
    jacobian[i] = rates[i];
}
EACH(i, @nq) {
    EACH(k, @nq) {
        for (int j = 0; j <= k; ++j) {
            second[@nj * i + @nq * j + k] = rates[@nj + @pairs * i + (k * (k + 1)) / 2 + j];
            second[@nj * i + @nq * k + j] = second[@nj * i + @nq * j + k];
        }
    }
}
