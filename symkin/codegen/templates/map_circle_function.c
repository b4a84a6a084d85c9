/* Cosine and sine of an angle@{circle_error}. */
static @{SHARED} void @{p}_circle(@{real} angle, @{real} circle[2])
{
@{circle}
}

