/* @{p} for C++17 and later; with C++20 arrays of known size are taken as std::span.
 * @{stamp}
 * SPDX-License-Identifier: MIT
 *
 * What functions do, and when, is told in @{p}.h.
 */
#ifndef @{P}_HPP
#define @{P}_HPP

#include "@{p}.h"

#include <array>
#include <cstddef>
#if __cplusplus >= 202002L
#include <span>
#endif

namespace @{namespace} {

using real = ::@{p}_real;
@{pose}
using config = ::@{p}_config;
using info = ::@{p}_info;
@{geometry_type}

inline constexpr std::size_t joint_count = @{P}_JOINTS;
inline constexpr real size = @{P}_SIZE;
inline constexpr config usual_config = {@{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP};
@{limit}

using joint_values = std::array<real, joint_count>;
@{arrays}

#if __cplusplus >= 202002L
template <std::size_t count> using view = std::span<const real, count>;
#else
template <std::size_t count> using view = const std::array<real, count> &;
#endif

enum class status {
    ok = @{P}_OK,
    max_iterations = @{P}_MAX_ITERATIONS,
    singular = @{P}_SINGULAR,
    nonfinite = @{P}_NONFINITE,
    out_of_range = @{P}_OUT_OF_RANGE,
    wrong_branch = @{P}_WRONG_BRANCH
};

/// A status and what was found: `value` means something where the status is ok, `details` where the function in C has an info.
template <typename T> struct outcome {
    status state;
    T value;
    info details;
    [[nodiscard]] explicit constexpr operator bool() const noexcept { return state == status::ok; }
};

@{functions}
@{all}
} // namespace @{namespace}

#endif
