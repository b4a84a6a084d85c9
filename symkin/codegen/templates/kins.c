/* LinuxCNC kinematics of @{p}: joints in @{units}, world in mm and degrees.
 * @{stamp}
 * SPDX-License-Identifier: MIT
 *
 *     halcompile --install @{p}_kins.c
 *     [KINS] KINEMATICS = @{p}_kins, JOINTS = @{nq}; [TRAJ] LINEAR_UNITS = mm, ANGULAR_UNITS = degree
 *
 * @{turns_told}@{pins_told}
 */
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_math.h"
#include "hal.h"
#include "kinematics.h"

/* halcompile compiles one file */
#include "@{p}.c"

KINS_NOT_SWITCHABLE
EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
MODULE_LICENSE("Dual MIT/GPL");

#define @{P}_DEGREES (57.29577951308232) /* of a radian */
#define @{P}_MM (@{mm}) /* of a unit of length */

static int @{p}_component;
@{memory}
@{pins}
@{conversions}
KINEMATICS_TYPE kinematicsType(void)
{
    return KINEMATICS_BOTH;
}

@{functions}
int rtapi_app_main(void)
{
    int fault = 0;
    @{p}_component = hal_init("@{p}_kins");
    if (@{p}_component < 0) {
        return @{p}_component;
    }
@{new_pins}
    if (fault == 0) {
        (void)hal_ready(@{p}_component);
    } else {
        (void)hal_exit(@{p}_component);
    }
    return fault;
}

void rtapi_app_exit(void)
{
    (void)hal_exit(@{p}_component);
}
