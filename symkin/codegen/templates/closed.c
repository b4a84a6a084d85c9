/* Joint values of branches with the tool pose x (unit quaternion); returns how many. wanted: two bits a choice, 1 for its first
 * solution, 2 for its second, 0 for the one nearest to the guess; near: cosine and sine of the guess's angle, or its slide and 0, of
 * each choice. *undecided is set where nothing decides a joint; margin: squares that vanish where steps decide nothing or two solutions
 * meet. */
static int name_branches(const name_real x[7], const name_real near[@nears], unsigned int wanted, name_real found[][@nn], bool *undecided,
    name_real margin[@margins])
{
    int count = 0;
    (void)margin;
    (void)near;
    (void)wanted;
    @body
    return count;
}

/* Turns angles to within half a turn of `about`, and, where that is out of range, of the middle of the range. */
static name_status name_turn_near(ABOUT_AND_JOINTS)
{
    static const bool angular[@nn] = { @angular };
    TABLE(middle, @nn, @middles)
    name_status status = NAME_OUT_OF_RANGE;
    EACH_WHILE(round, 2, (status == NAME_OUT_OF_RANGE)) {
        const name_real *const goal = (round == 0) ? about : middle;
        EACH(i, @nn) {
            const name_real number = (goal[i] - joints[i]) * 0.15915494309189535;
            if (angular[i] && (fabs(number) > 0.5) && (fabs(number) < @many)) {
                const int whole = NEAREST_WHOLE(number);
                joints[i] += 6.283185307179586 * (name_real)whole;
            }
        }
        status = name_limit_joints(NAME_OK, joints);
    }
    return status;
}

@finish
/* The branch that the bits `wanted` and the guess name; results are written with OK only. */
static name_status name_one_branch(const name_pose *pose, const name_real near[@nears], unsigned int wanted, ABOUT_AND_JOINTS)
{
    name_real x[7];
    name_real found[1][@nn];
    name_real margin[@margins];
    bool undecided = false;
    name_status status = name_normalise_pose(pose, x);
    IF_OK {
        if (name_branches(x, near, wanted, found, &undecided, margin) == 1) {
            status = name_settle(x, about, found[0]);
        } else {
            status = undecided ? NAME_SINGULAR : NAME_OUT_OF_RANGE;
        }
    }
    IF_OK {
        COPY(joints, found[0], @nn)
    }
    return status;
}

/* All branches with the given tool pose. */
int name_inverse_all(const name_pose *pose, name_real joints[@branches][@nn])
{
    TABLE(near, @nears, 0.0)
    TABLE(middle, @nn, @middles)
    name_real x[7];
    int count = 0;
    name_real margin[@margins];
    bool undecided = false;
    name_status status = name_normalise_pose(pose, x);
    IF_OK {
        const int all = name_branches(x, near, @both, joints, &undecided, margin);
        EACH(k, all) {
            if (name_settle(x, middle, joints[k]) == NAME_OK) {
                COPY(joints[count], joints[k], @nn)
                ++count;
            }
        }
    }
    return count;
}

/* The branch named by the choices' bits. */
name_status name_inverse_branch(const name_pose *pose, unsigned int branch, name_real joints[@nn])
{
    TABLE(near, @nears, 0.0)
    TABLE(middle, @nn, @middles)
    name_status status = NAME_OUT_OF_RANGE;
    if (branch < @{branches}U) {
        unsigned int wanted = 0U;
        @named
        status = name_one_branch(pose, near, wanted, middle, joints);
    }
    return status;
}

/* The branch nearest to the guess, choice by choice. */
name_status name_inverse_nearest(const name_pose *pose, const name_real guess[@nn], name_real joints[@nn])
{
    name_status status = NAME_OK;
    EACH(i, @nn) {
        if (!(fabs(guess[i]) <= @farthest_joint)) {
            status = NAME_OUT_OF_RANGE;
        }
    }
    IF_OK {
        name_real near[@nears] = { 0.0 };
        @near
        status = name_one_branch(pose, near, 0U, guess, joints);
    } else {
        name_real x[7];
        const name_status posed = name_normalise_pose(pose, x);
        status = name_check_finite(guess, @nn, (posed == NAME_OK) ? status : posed);
    }
    return status;
}

