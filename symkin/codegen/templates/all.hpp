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
