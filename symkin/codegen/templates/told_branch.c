/* Checks the branch of an answer, passive joints and pose coordinates x: whether each limb stands on the reference's side of its dead
 * centres, which is a sign. Else a limb has passed one on the way, which is a singularity. Beside a dead centre the pose, rounded, may
 * lie beyond it: where the pose does not give the joint values back none is OK, and where it does not tell the side only what stands still,
 * from the guess's joint values `at`. */
static NAME_COLD name_status name_check_branch(GEOMETRY_GIVEN const name_real x[@count], const name_real at[@nq], const name_real given[@nq])
{
    name_status status = NAME_OK;
    bool firm = true;
    bool told = true;
    (void)x;
    @told
    if ((status == NAME_OK) && !told) {
        status = name_check_near(at, given);
    }
    if ((status == NAME_OK) && !firm) {
        status = name_check_given(GEOMETRY @answer, given);
    }
    return status;
}

