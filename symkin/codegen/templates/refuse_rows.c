/* Rows of values that are refused: of given ones, or (as_guess) of guesses; blamed: the joint of each row, NULL where nobody asks. */
static void refuse_rows(const function *asked, const name_real *rows, int count, int as_guess, name_status wanted, const int *blamed)
{
    EACH(k, count) {
        const name_real *const given = as_guess ? asked->values : &rows[asked->given * k];
        const name_real *const guess = as_guess ? &rows[asked->found * k] : asked->guesses;
        refuse(asked, asked->ask, given, guess, wanted, (blamed == NULL) ? -1 : blamed[k], k);
    }
}

