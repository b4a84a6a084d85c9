/* For Arduino, which compiles src/ alone: the header beside this folder.
 * SPDX-License-Identifier: MIT */
#include "../@{p}.h"
