/* The twist of joint rates: the Jacobian's linear system, lengths and angles times the size. */
@static_own name_status @twist(GEOMETRY_GIVEN const name_pose *pose, const name_real rates[@nq], name_real twist[6])
{
    TABLE(row_scale, @nq, @row_scales)
    TABLE(column_scale, @nq, @column_scales)
    static const uint8_t column[@nq] = { @columns };
    TABLE(least, @nq, @least_pivots)
    name_real jacobian[@nq * 6];
    name_real a[@nq * @nq];
    name_real f[@nq];
    uint8_t order[@nq];
    name_status status = name_check_sizes(rates, @nq, -@largest, @jacobian(GEOMETRY pose, jacobian));
    IF_OK {
        EACH(i, @nq) {
            EACH(j, @nq) {
                a[@nq * i + j] = jacobian[6 * i + (int)column[j]] * row_scale[i] * column_scale[j];
            }
            f[i] = rates[i] * row_scale[i];
        }
        if (name_lu(a, order, least, @nq) == 0) {
            status = NAME_SINGULAR;
        }
    }
    IF_OK {
        name_lu_solve(a, order, f, f, @nq);
        @others
        EACH(i, @nq) {
            twist[column[i]] = f[i] * column_scale[i];
        }
    }
    return status;
}

