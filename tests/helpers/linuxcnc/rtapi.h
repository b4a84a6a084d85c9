/* What a component sees of LinuxCNC's header of this name. */
#ifndef RTAPI_H
#define RTAPI_H
#endif
