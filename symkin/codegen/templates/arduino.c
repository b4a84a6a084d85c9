/* For Arduino, which compiles src/ alone: the source beside this folder.
 * SPDX-License-Identifier: MIT */
#include "../@{p}.c"
