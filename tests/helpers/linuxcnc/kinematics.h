/* What a component sees of LinuxCNC's header of this name: its declarations hold the component to the interface. */
#ifndef KINEMATICS_H
#define KINEMATICS_H
#include "emcpos.h"
typedef enum { KINEMATICS_IDENTITY = 1, KINEMATICS_FORWARD_ONLY, KINEMATICS_INVERSE_ONLY, KINEMATICS_BOTH } KINEMATICS_TYPE;
typedef unsigned long int KINEMATICS_FORWARD_FLAGS;
typedef unsigned long int KINEMATICS_INVERSE_FLAGS;
extern int kinematicsForward(const double *joint, struct EmcPose *world, const KINEMATICS_FORWARD_FLAGS *fflags, KINEMATICS_INVERSE_FLAGS *iflags);
extern int kinematicsInverse(const struct EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *iflags, KINEMATICS_FORWARD_FLAGS *fflags);
extern KINEMATICS_TYPE kinematicsType(void);
extern int kinematicsSwitchable(void);
extern int kinematicsSwitch(int switchkins_type);
#define KINS_NOT_SWITCHABLE                                                      \
    int kinematicsSwitchable(void) { return 0; }                                 \
    int kinematicsSwitch(int switchkins_type) { (void)switchkins_type; return 0; } \
    EXPORT_SYMBOL(kinematicsSwitchable);                                         \
    EXPORT_SYMBOL(kinematicsSwitch);
#endif
