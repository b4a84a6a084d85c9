/* Joint centres on the base (base frame) and on the platform (platform frame), and rod lengths at zero. */
typedef struct {
    @{p}_real base[6][3];
    @{p}_real platform[6][3];
    @{p}_real offset[6];
} @{p}_geometry;

/* Nominal geometry, as an initialiser. */
#define @{P}_NOMINAL \
    { { @{base} }, \
      { @{ends} }, \
      { @{offsets} } }
