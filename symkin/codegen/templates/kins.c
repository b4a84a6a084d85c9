/* LinuxCNC kinematics of @p: joints in @units, world in mm and degrees.
 * @stamp
 * SPDX-License-Identifier: MIT
 *
 *     halcompile --install name_kins.c
 *     [KINS] KINEMATICS = name_kins, JOINTS = @nq; [TRAJ] LINEAR_UNITS = mm, ANGULAR_UNITS = degree
 *
 * @turns_told@pins_told
 */
#include "rtapi.h"
#include "rtapi_app.h"
#include "rtapi_math.h"
#include "hal.h"
#include "kinematics.h"

/* halcompile compiles one file */
#include "@p.c"

KINS_NOT_SWITCHABLE
EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
MODULE_LICENSE("Dual MIT/GPL");

#define NAME_DEGREES (57.29577951308232) /* of a radian */
#define NAME_MM (@mm) /* of a unit of length */

static int name_component;
@memory
@pins
@conversions
KINEMATICS_TYPE kinematicsType(void)
{
    return KINEMATICS_BOTH;
}

int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags, KINEMATICS_INVERSE_FLAGS *iflags)
{
    static const double unit[@nq] = { @joint_units };
    double joints[@nq];
    name_pose pose;
    name_status status;
@geometry
    (void)fflags;
    (void)iflags;
    READ_JOINTS
@forward
    if (status != NAME_OK) {
        return -1;
    }
@remembered
    world->tran.x = pose.position[0] * NAME_MM;
    world->tran.y = pose.position[1] * NAME_MM;
    world->tran.z = pose.position[2] * NAME_MM;
    name_world_of(&pose, world);
    return 0;
}

/* The joints that are there when it is called are the guess, where one is asked for. */
int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags, KINEMATICS_FORWARD_FLAGS *fflags)
{
    static const double unit[@nq] = { @joint_units };
    const name_pose pose = name_pose_of(world);
    double joints[@nq];
@geometry
    (void)iflags;
    (void)fflags;
    READ_JOINTS
    if (name_inverse(@ga@inverse) != NAME_OK) {
        return -1;
    }
    EACH(i, @nq) {
        joint[i] = joints[i] * unit[i];
    }
@remembered
    return 0;
}

int rtapi_app_main(void)
{
    int fault = 0;
    name_component = hal_init("name_kins");
    if (name_component < 0) {
        return name_component;
    }
    @new_pins
    if (fault == 0) {
        (void)hal_ready(name_component);
    } else {
        (void)hal_exit(name_component);
    }
    return fault;
}

void rtapi_app_exit(void)
{
    (void)hal_exit(name_component);
}
