/* Joint centres on the base (base frame) and on the platform (platform frame), and rod lengths at zero. Numbers beyond @largest are NAME_OUT_OF_RANGE. */
typedef struct {
    name_real base[6][3];
    name_real platform[6][3];
    name_real offset[6];
} name_geometry;

/* Nominal geometry, as an initialiser. */
#define NAME_NOMINAL \
    { { @base }, \
      { @ends }, \
      { @offsets } }
