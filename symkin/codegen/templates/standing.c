IF_OK {
    const name_real *const q = guess->quaternion;
    const name_real squared = DOT3(q, q) + q[3] * q[3];
    status = (fabs(squared - 1.0) <= @unit_error) ? name_check_near(w.at, given) : NAME_WRONG_BRANCH;
}
@standing_passive
standing = (status == NAME_OK);
