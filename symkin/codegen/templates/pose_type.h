/* Position in @unit, unit quaternion (w, x, y, z), both of the @frame frame in the base frame@relative. */
typedef struct {
    name_real position[3];
    name_real quaternion[4];
} name_pose;
