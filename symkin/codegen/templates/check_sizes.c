/* The status of values beside that of what was found so far: NONFINITE, or OUT_OF_RANGE below `least` and beyond what products bear. */
static name_status name_check_sizes(const name_real values[], int count, name_real least, name_status before)
{
    name_status status = name_check_finite(values, count, before);
    EACH_WHILE(i, count, (status == NAME_OK)) {
        status = ((values[i] < least) || (values[i] > @largest)) ? NAME_OUT_OF_RANGE : NAME_OK;
    }
    return status;
}

