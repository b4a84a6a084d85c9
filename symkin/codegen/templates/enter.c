LIMB_VALUES
status = name_pose_coordinates(GEOMETRY guess, c);
IF_OK {
    status = name_solve_limbs(GEOMETRY c, w->at, passive@of_answer);
    @copied
    @turned
    @placed
    status = (status == NAME_OK) ? status : NAME_OUT_OF_RANGE;
}
