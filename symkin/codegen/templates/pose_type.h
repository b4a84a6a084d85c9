/* Position in @{unit}, unit quaternion (w, x, y, z), both of the @{frame} frame in the base frame@{relative}. */
typedef struct {
    @{p}_real position[3];
    @{p}_real quaternion[4];
} @{p}_pose;
