/* Whether two lists of joint values are the same within a bound (of angles times half of the size), whole turns left aside. */
static int same_joints(const @{p}_real *a, const @{p}_real *b, double bound)
{
    static const int angular[N] = { @{angular} };
    int same = 1;
    for (int i = 0; i < N; ++i) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? 0.5 * (double)@{P}_SIZE * fabs(remainder(gap, 6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name. */
static void branches_of(const function *direct, int k)
{
    const double most = 8.0 * @{p}_vector_bounds[k];
    const @{p}_real *const given = @{p}_vector_poses[k];
    const @{p}_pose pose = pose_from(given);
    @{p}_real all[@{P}_BRANCHES][N];
    @{p}_real one[MOST];
    const int count = @{p}_inverse_all(&pose, all);
    int found = 0;
    int named = 0;
    expect((count > 0) && (count <= @{P}_BRANCHES), "inverse_all", "count", k);
    for (int row = 0; row < count; ++row) {
        expect(direct->ask(NULL, all[row], NULL, one, NULL) == @{P}_OK, "inverse_all", "direct of a branch", k);
        expect(away(direct, one, given) <= @{reached}, "inverse_all", "a branch's pose", k);
        found += same_joints(all[row], @{p}_vector_inverse[k], most);
    }
    expect(found == 1, "inverse_all", "one branch is the arm", k);
    for (unsigned int branch = 0U; branch < @{P}_BRANCHES; ++branch) {
        if (@{p}_inverse_branch(&pose, branch, one) == @{P}_OK) {
            expect((named < count) && same_joints(one, all[named], most), "inverse_branch", "a branch by its name", k);
            ++named;
        }
    }
    expect(named == count, "inverse_branch", "count of the branches by name", k);
}

/* What is no pose or no branch is refused, results untouched. */
static void refuse_branches(void)
{
    const @{p}_pose pose = pose_from(@{p}_vector_poses[0]);
    @{p}_pose infinite = pose;
    @{p}_real all[@{P}_BRANCHES][N];
    @{p}_real joints[N];
    for (int i = 0; i < N; ++i) {
        joints[i] = @{four};
    }
    infinite.position[2] = wrong[1];
    expect(@{p}_inverse_branch(&pose, @{P}_BRANCHES, joints) == @{P}_OUT_OF_RANGE, "inverse_branch", "no such branch", 0);
    expect(@{p}_inverse_branch(&infinite, 0U, joints) == @{P}_NONFINITE, "inverse_branch", "infinite pose", 0);
    expect(@{p}_inverse_all(&infinite, all) == 0, "inverse_all", "infinite pose", 0);
    expect(all_are(joints, N, @{four}), "inverse_branch", "result untouched", 0);
}

