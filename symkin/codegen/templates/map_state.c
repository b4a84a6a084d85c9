/* All numbers y of the configuration that has the values: of angles cosine and sine, in the order given, found, passive. The choices
 * that the values leave are those of the reference configuration. `other` are the values of the other side. */
static NAME_SHARED name_status name_state_of_@values(const name_real values[@nto], name_real y[@ny], name_real other[@nto])
{
    name_status status = NAME_OK;
    @lines
    return status;
}

