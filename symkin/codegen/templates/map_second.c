name_joint_bends(&w, steps, sides);
for (int j = 0; j < @{pairs}; ++j) {
    for (int i = 0; i < @{m}; ++i) {
        w.f[i] = sides[@{pairs} * i + j];
    }
    solver_solve(&w);
    @{seconds}
}
