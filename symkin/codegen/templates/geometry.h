/* Geometry by the model's key paths: lengths, angles in radians, directions and quaternions of any length from @shortest on; shorter ones
 * and numbers beyond @largest are NAME_OUT_OF_RANGE. Branches and pivots were chosen for the nominal values: give what a calibration finds, not another machine. Where constraints
 * depend on one another, values that contradict them leave no pose, and no call is OK. */
typedef struct {
    @members
} name_geometry;

/* Nominal geometry, as an initialiser. */
#define NAME_NOMINAL \
    { \
        @numbers
    }
