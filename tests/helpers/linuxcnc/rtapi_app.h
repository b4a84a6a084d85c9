/* What a component sees of LinuxCNC's header of this name. */
#ifndef RTAPI_APP_H
#define RTAPI_APP_H
#define EXPORT_SYMBOL(x) extern char exported_##x
#define MODULE_LICENSE(x) static const char module_license[] __attribute__((used)) = x
extern int rtapi_app_main(void);
extern void rtapi_app_exit(void);
#endif
