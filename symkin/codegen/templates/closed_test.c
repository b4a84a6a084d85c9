/* Whether two lists of joint values are the same within a bound (of angles times half of the size), whole turns left aside. */
static int same_joints(const name_real *a, const name_real *b, double bound)
{
    static const int angular[N] = { @angular };
    int same = 1;
    EACH(i, N) {
        const double gap = (double)a[i] - (double)b[i];
        const double off = angular[i] ? 0.5 * (double)NAME_SIZE * fabs(remainder(gap, 6.283185307179586)) : fabs(gap);
        same = same && (off <= bound);
    }
    return same;
}

/* All branches reach the pose, one of them is the arm, each is found by its name. */
static void branches_of(const function *direct, int k)
{
    const double most = 8.0 * name_vector_bounds[k];
    const name_real *const given = name_vector_poses[k];
    const name_pose pose = pose_from(given);
    name_real all[NAME_BRANCHES][N];
    name_real one[MOST];
    const int count = name_inverse_all(&pose, all);
    int found = 0;
    int named = 0;
    expect((count > 0) && (count <= NAME_BRANCHES), "inverse_all", "count", k);
    EACH(row, count) {
        expect(direct->ask(NULL, all[row], NULL, one, NULL) == NAME_OK, "inverse_all", "direct of a branch", k);
        expect(away(direct, one, given) <= @reached, "inverse_all", "a branch's pose", k);
        found += same_joints(all[row], name_vector_inverse[k], most);
    }
    expect(found == 1, "inverse_all", "one branch is the arm", k);
    for (unsigned int branch = 0U; branch < NAME_BRANCHES; ++branch) {
        if (name_inverse_branch(&pose, branch, one) == NAME_OK) {
            expect((named < count) && same_joints(one, all[named], most), "inverse_branch", "a branch by its name", k);
            ++named;
        }
    }
    expect(named == count, "inverse_branch", "count of the branches by name", k);
}

/* What is no pose or no branch is refused, results untouched. */
static void refuse_branches(void)
{
    const name_pose pose = pose_from(name_vector_poses[0]);
    name_pose infinite = pose;
    name_real all[NAME_BRANCHES][N];
    name_real joints[N];
    EACH(i, N) {
        joints[i] = @four;
    }
    infinite.position[2] = wrong[1];
    expect(name_inverse_branch(&pose, NAME_BRANCHES, joints) == NAME_OUT_OF_RANGE, "inverse_branch", "no such branch", 0);
    expect(name_inverse_branch(&infinite, 0U, joints) == NAME_NONFINITE, "inverse_branch", "infinite pose", 0);
    expect(name_inverse_all(&infinite, all) == 0, "inverse_all", "infinite pose", 0);
    expect(all_are(joints, N, @four), "inverse_branch", "result untouched", 0);
}

