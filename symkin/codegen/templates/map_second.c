@{p}_joint_bends(&w, steps, sides);
for (int j = 0; j < @{pairs}; ++j) {
    for (int i = 0; i < @{m}; ++i) {
        w.f[i] = sides[@{pairs} * i + j];
    }
    @{k}_solve(&w);
@{seconds}
}
