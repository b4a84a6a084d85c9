
/* Whether two lists of joint values are the same within a bound (of angles times half of the size), whole turns left aside. */
static int same_joints(const @{p}_real a[@{P}_JOINTS], const @{p}_real b[@{P}_JOINTS], double bound)
{
    static const int angular[@{P}_JOINTS] = { @{angular} };
    int same = 1;
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? 0.5 * (double)@{P}_SIZE * fabs(remainder(gap, 6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name, the guess's is the nearest. */
static void closed_form(void)
{
    for (int k = 0; k < @{P}_VECTORS; ++k) {
        const double bound = @{p}_vector_bounds[k];
        const double most = 8.0 * bound;
        const @{p}_pose pose = pose_from(@{p}_vector_poses[k]);
        @{p}_real all[@{P}_BRANCHES][@{P}_JOINTS];
        @{p}_real one[@{P}_JOINTS];
        const int count = @{p}_inverse_all(&pose, all);
        int found = 0;
        int named = 0;
        expect((count > 0) && (count <= @{P}_BRANCHES), "count of all branches", k);
        for (int row = 0; row < count; ++row) {
            @{p}_pose again;
            expect(@{p}_direct(all[row], &again) == @{P}_OK, "direct of a branch", k);
            for (int i = 0; i < 3; ++i) {
                expect(fabs((double)again.position[i] - (double)pose.position[i]) <= @{reached}, "a branch's position", k);
            }
            for (int i = 0; i < 4; ++i) {
                const double off = fabs(fabs((double)again.quaternion[i]) - fabs((double)pose.quaternion[i]));
                expect((double)@{P}_SIZE * off <= @{reached}, "a branch's quaternion", k);
            }
            found += same_joints(all[row], @{p}_vector_inverse[k], most);
        }
        expect(found == 1, "one branch is the arm", k);
        for (unsigned int branch = 0U; branch < @{P}_BRANCHES; ++branch) {
            if (@{p}_inverse_branch(&pose, branch, one) == @{P}_OK) {
                expect((named < count) && same_joints(one, all[named], most), "a branch by its name", k);
                ++named;
            }
        }
        expect(named == count, "count of the branches by name", k);
        expect(@{p}_inverse_nearest(&pose, @{p}_vector_guesses[k], one) == @{P}_OK, "nearest branch", k);
        for (int i = 0; i < @{P}_JOINTS; ++i) {
            expect(fabs((double)one[i] - (double)@{p}_vector_inverse[k][i]) <= most@{angle_bound}, "nearest branch's joints", k);
        }
    }
}

/* What is no pose, no branch or out of reach is refused, results untouched. */
static void closed_refusals(void)
{
    const @{p}_pose pose = pose_from(@{p}_vector_poses[0]);
    @{p}_pose wrong = pose;
    @{p}_real all[@{P}_BRANCHES][@{P}_JOINTS];
    @{p}_real joints[@{P}_JOINTS];
    @{p}_real guess[@{P}_JOINTS];
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        joints[i] = @{four};
        guess[i] = @{p}_vector_guesses[0][i];
    }
    expect(@{p}_inverse_branch(&pose, @{P}_BRANCHES, joints) == @{P}_OUT_OF_RANGE, "no such branch", 0);
    guess[0] = (@{p}_real)NAN;
    expect(@{p}_inverse_nearest(&pose, guess, joints) == @{P}_NONFINITE, "NaN guess of the closed form", 0);
    guess[0] = @{p}_vector_guesses[0][0];
    wrong.position[2] = (@{p}_real)INFINITY;
    expect(@{p}_inverse_nearest(&wrong, guess, joints) == @{P}_NONFINITE, "infinite pose of the closed form", 0);
    expect(@{p}_inverse_branch(&wrong, 0U, joints) == @{P}_NONFINITE, "infinite pose of the closed form", 1);
    expect(@{p}_inverse_all(&wrong, all) == 0, "infinite pose of the closed form", 2);
    wrong = pose;
    wrong.quaternion[1] = @{two};
    expect(@{p}_inverse_nearest(&wrong, guess, joints) == @{P}_OUT_OF_RANGE, "quaternion of length 2 of the closed form", 0);
    wrong = pose;
    wrong.position[0] = @{far};
    wrong.position[1] = @{far};
    wrong.position[2] = @{far};
    (void)@{p}_inverse_nearest(&wrong, guess, joints);
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        expect(joints[i] == @{four}, "result of the closed form untouched on failure", i);
    }
}
