/* What several templates say: macros, which are put in as templates are read. Lines of one alone on a line stand as deep as it. */
#define EACH_FROM(i, first, n) for (int i = first; i < n; ++i)
#define EACH(i, n) EACH_FROM(i, 0, n)
#define EACH_WHILE(i, n, going) for (int i = 0; (i < n) && going; ++i)
#define COPY(to, from, n) EACH(i, n) { \
    to[i] = from[i]; \
}
#define IF_OK if (status == NAME_OK)
#define NO_INFO name_write_info(info, 0U, HUGE_VAL, 0.0, 0.0);
#define CHECK_CONFIG if (config != NULL) { \
    status = name_check_config(config, status); \
}
#define BLAME(number) if (info != NULL) { \
    info->joint = number; \
}
#define USUAL_CONFIG static const name_config usual = { NAME_TOLERANCE, NAME_MAX_STEPS, NAME_MAX_STEP };
#define ASK(what, given) tested = "what"; \
expect(name_##what##given == NAME_OK, "OK", k);
#define NEAREST_WHOLE(number) (int)(number + ((number < 0.0) ? -0.5 : 0.5))
#define JOINTS_GIVEN const name_real joints[@nq]
#define VALUES_GIVEN const name_real @values[@nto]
#define ABOUT_AND_JOINTS const name_real about[@nn], name_real joints[@nn]
#define CONFIG_AND_INFO const name_config *config, name_info *info
#define OWN_WORK solver_work work; \
solver_work *const w = &work;
#define GUARD_ENDS const name_real left = w->left[k] - rounding; \
const name_real guard = w->guard[k] - rounding; \
const bool above = (left > 0.0) && (guard > 0.0);
#define TABLE(table, count, numbers) static const name_real table[count] = { numbers };
#define LIMB_VALUES name_real c[@nc]; \
name_real passive[@np] = { 0.0 };
#define QUATERNIONS_DOT(x, y) (x[3] * y[3]) + (x[4] * y[4]) + (x[5] * y[5]) + (x[6] * y[6])
#define DOT3(a, b) a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
#define READ_JOINTS EACH(i, @nq) { \
    joints[i] = joint[i] / unit[i]; \
}
#define POSE_OF_WORLD static name_pose name_pose_of(const EmcPose *world)
#define WORLD_OF_POSE static void name_world_of(const name_pose *pose, EmcPose *world)
