/* What a component sees of LinuxCNC's header of this name. */
#ifndef RTAPI_MATH_H
#define RTAPI_MATH_H
#include <math.h>
#endif
