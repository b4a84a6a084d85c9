/* What a component sees of LinuxCNC's header of this name. */
#ifndef EMCPOS_H
#define EMCPOS_H
typedef struct {
    double x, y, z;
} PmCartesian;
typedef struct EmcPose {
    PmCartesian tran;
    double a, b, c;
    double u, v, w;
} EmcPose;
#endif
