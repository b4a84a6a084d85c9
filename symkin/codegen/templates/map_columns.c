/* Derivatives of the rows by the @{of}, row by row. */
static void @{p}_@{columns}(const @{k}_work *w, @{real} sides[@{nsides}])
{
    (void)w;
@{sides}
}

