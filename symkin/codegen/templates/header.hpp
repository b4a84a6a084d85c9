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
{% if not is_map %}
using pose = ::@{p}_pose;
{% endif %}
using config = ::@{p}_config;
using info = ::@{p}_info;
{% if struct %}
using geometry = ::@{p}_geometry;
{% endif %}

inline constexpr std::size_t joint_count = @{P}_JOINTS;
inline constexpr real size = @{P}_SIZE;
inline constexpr config usual_config = {@{P}_TOLERANCE, @{P}_MAX_STEPS, @{P}_MAX_STEP};
{% if limit %}
inline constexpr real track_limit = @{P}_TRACK_LIMIT;
{% endif %}

using joint_values = std::array<real, joint_count>;
{% if is_map %}
using matrix = std::array<real, joint_count * joint_count>;
struct derivatives {
    matrix jacobian;
    std::array<real, joint_count * joint_count * joint_count> second;
};
{% else %}
using twist_values = std::array<real, 6>;
using matrix = std::array<real, 6 * joint_count>;
{% endif %}

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

{% for f in functions %}
{% set takes, call = (["const geometry &numbers"], ["&numbers"]) if struct else ([], []) %}
{% if f.config %}{% do call.append("settings") %}{% endif %}
{% for value in f.takes %}
{% set name = "at" if value.name in ("pose", "found") else value.name %}
{% if value.type == "pose" %}
{% do takes.append("const pose &" ~ name) %}
{% do call.append("&" ~ name) %}
{% elif value.type == "unsigned int" %}
{% do takes.append("unsigned int " ~ name) %}
{% do call.append(name) %}
{% else %}
{% do takes.append("view<" ~ ("6" if value.count == "6" else "joint_count") ~ "> " ~ name) %}
{% do call.append(name ~ ".data()") %}
{% endif %}
{% endfor %}
{% set result = "derivatives" if f.gives | length > 1 else (f.gives | map(attribute="type") | first | default("bool")) %}
{% for value in f.gives %}
{% set member = "found.value" ~ ("." ~ value.name if f.gives | length > 1 else "") %}
{% do call.append("&" ~ member if value.type in ("pose", "real") else member ~ ".data()") %}
{% endfor %}
{% if f.moves %}{% do takes.append("const " ~ result ~ " &last") %}{% endif %}
{% if f.config %}{% do takes.append("const config *settings = nullptr") %}{% endif %}
{% if f.info %}{% do call.append("&found.details") %}{% endif %}
{% if f.about %}
/// @{words(f)}.
{% endif %}
[[nodiscard]] inline outcome<@{result}> @{f.name}(@{takes | join(", ")}) noexcept
{
    outcome<@{result}> found{};
{% if f.moves %}
    found.value = last;
{% elif not f.gives %}
    found.value = true;
{% endif %}
    found.state = static_cast<status>(::@{p}_@{f.name}(@{call | join(", ")}));
    return found;
}
{% if not loop.last %}

{% endif %}
{% endfor %}
{% if branches %}
inline constexpr std::size_t branch_count = @{P}_BRANCHES;

/// The joint values of all branches of a pose: the first `count`.
struct branches {
    std::size_t count;
    std::array<joint_values, branch_count> values;
};

[[nodiscard]] inline branches inverse_all(const pose &at) noexcept
{
    real found[branch_count][joint_count];
    branches all{};
    all.count = static_cast<std::size_t>(::@{p}_inverse_all(&at, found));
    for (std::size_t i = 0; i < all.count; ++i) {
        for (std::size_t j = 0; j < joint_count; ++j) {
            all.values[i][j] = found[i][j];
        }
    }
    return all;
}
{% endif %}
} // namespace @{namespace}

#endif
