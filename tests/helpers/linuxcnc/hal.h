/* What a component sees of LinuxCNC's header of this name. */
#ifndef HAL_H
#define HAL_H
#define HAL_NAME_LEN 47
typedef enum { HAL_IN = 16, HAL_OUT = 32, HAL_IO = HAL_IN | HAL_OUT } hal_pin_dir_t;
typedef volatile double hal_float_t;
extern int hal_init(const char *name);
extern int hal_exit(int comp_id);
extern int hal_ready(int comp_id);
extern void *hal_malloc(long int size);
extern int hal_pin_float_newf(hal_pin_dir_t dir, hal_float_t **data_ptr_addr, int comp_id, const char *fmt, ...)
    __attribute__((format(printf, 4, 5)));
#endif
