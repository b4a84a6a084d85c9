/* Derivatives of the rows by the @{of}, row by row. */
static void name_@{columns}(const solver_work *w, name_real sides[@{nsides}])
{
    (void)w;
    @{sides}
}

