/* Loads a component as LinuxCNC would, and asks it: lines "i x y z a b c j0 j1 ..." for the inverse (joints are the guess), "f j0 j1 ..."
 * for the forward problem, "p NAME VALUE" for a pin. Answers: the status and the numbers. */
#include "hal.h"
#include "kinematics.h"
#include "rtapi_app.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static struct {
    char name[HAL_NAME_LEN + 1];
    double value;
} pins[256];
static int pin_count = 0;
static int ready = 0;

int hal_init(const char *name)
{
    return (strlen(name) <= HAL_NAME_LEN) ? 7 : -1;
}

int hal_exit(int comp_id)
{
    ready = 0;
    return comp_id == 7 ? 0 : -1;
}

int hal_ready(int comp_id)
{
    ready = 1;
    return comp_id == 7 ? 0 : -1;
}

void *hal_malloc(long int size)
{
    return malloc((size_t)size);
}

int hal_pin_float_newf(hal_pin_dir_t dir, hal_float_t **data_ptr_addr, int comp_id, const char *fmt, ...)
{
    va_list arguments;
    int length;
    va_start(arguments, fmt);
    length = vsnprintf(pins[pin_count].name, sizeof pins[0].name, fmt, arguments);
    va_end(arguments);
    if (length > HAL_NAME_LEN || comp_id != 7 || ready || dir == HAL_OUT) {
        return -1;
    }
    *data_ptr_addr = &pins[pin_count++].value;
    return 0;
}

int main(void)
{
    char kind;
    KINEMATICS_FORWARD_FLAGS fflags = 0;
    KINEMATICS_INVERSE_FLAGS iflags = 0;
    if (rtapi_app_main() != 0 || !ready || kinematicsType() != KINEMATICS_BOTH || kinematicsSwitchable()) {
        return 1;
    }
    while (scanf(" %c", &kind) == 1) {
        double joints[16] = { 0 };
        EmcPose world = { { 0, 0, 0 }, 0, 0, 0, 0, 0, 0 };
        int status = 0;
        if (kind == 'p') {
            char name[64];
            double value;
            status = scanf("%63s %lf", name, &value) == 2 ? -1 : -2;
            for (int i = 0; i < pin_count; ++i) {
                if (strcmp(pins[i].name, name) == 0) {
                    pins[i].value = value;
                    status = 0;
                }
            }
            printf("%d\n", status);
            continue;
        }
        if (kind == 'i' && scanf("%lf %lf %lf %lf %lf %lf", &world.tran.x, &world.tran.y, &world.tran.z, &world.a, &world.b, &world.c) != 6) {
            return 2;
        }
        for (int i = 0; i < JOINTS; ++i) {
            if (scanf("%lf", &joints[i]) != 1) {
                return 2;
            }
        }
        status = kind == 'i' ? kinematicsInverse(&world, joints, &iflags, &fflags) : kinematicsForward(joints, &world, &fflags, &iflags);
        printf("%d", status);
        if (kind == 'i') {
            for (int i = 0; i < JOINTS; ++i) {
                printf(" %.17g", joints[i]);
            }
        } else {
            printf(" %.17g %.17g %.17g %.17g %.17g %.17g", world.tran.x, world.tran.y, world.tran.z, world.a, world.b, world.c);
        }
        printf("\n");
    }
    rtapi_app_exit();
    return ready;
}
