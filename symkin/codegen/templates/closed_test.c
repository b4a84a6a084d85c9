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

/* All branches reach the pose, one of them is the arm, each is found by its name; what is no pose or no branch has none. */
static void branches_of(const function *direct, int k)
{
    const double most = 8.0 * name_vector_bounds[k];
    const name_real *const given = name_vector_poses[k];
    name_pose pose = pose_from(given);
    name_real all[NAME_BRANCHES][N];
    name_real one[MOST];
    const int count = name_inverse_all(&pose, all);
    int found = 0;
    int named = 0;
    tested = "inverse_all";
    expect((count > 0) && (count <= NAME_BRANCHES), "count", k);
    EACH(row, count) {
        expect(direct->ask(NULL, all[row], NULL, one, NULL) == NAME_OK, "direct of a branch", k);
        expect(away(direct, one, given) <= @reached, "a branch's pose", k);
        found += same_joints(all[row], name_vector_inverse[k], most);
    }
    expect(found == 1, "one branch is the arm", k);
    for (unsigned int branch = 0U; branch < NAME_BRANCHES; ++branch) {
        if (name_inverse_branch(&pose, branch, one) == NAME_OK) {
            expect((named < count) && same_joints(one, all[named], most), "a branch by its name", k);
            ++named;
        }
    }
    expect(named == count, "count of the branches by name", k);
    copy(all[0], one, N);
    expect(name_inverse_branch(&pose, NAME_BRANCHES, one) == NAME_OUT_OF_RANGE, "no such branch", k);
    expect(memcmp(all[0], one, sizeof all[0]) == 0, "result untouched", k);
    pose.position[2] = wrong[1];
    expect(name_inverse_all(&pose, all) == 0, "infinite pose", k);
}

