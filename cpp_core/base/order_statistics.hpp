// Values by their rank.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace togishi {

/// The value that `share` (0 to 1) of the others do not pass, one of them, no mean of two; 0 where
/// there are none. Puts them into another order.
template <class T>
[[nodiscard]] T quantile(std::vector<T>& values, double share) {
    if (values.empty()) return T{};
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

template <class T>
[[nodiscard]] T quantile(std::vector<T>&& values, double share) {
    return quantile(values, share);
}

/// The middle one, the upper of two; 0 where there are none. Puts them into another order.
template <class T>
[[nodiscard]] T median(std::vector<T>& values) {
    if (values.empty()) return T{};
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), at, values.end());
    return *at;
}
template <class T>
[[nodiscard]] T median(std::vector<T>&& values) {
    return median(values);
}

/// Of each value and its neighbours up to `reach` away on both sides, as many on either: a single
/// wrong value moves nothing.
[[nodiscard]] inline std::vector<double> running_median(const std::vector<double>& values,
                                                        std::size_t reach) {
    std::vector<double> result(values.size());
    std::vector<double> around;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const std::size_t n = std::min({reach, i, values.size() - 1 - i});
        around.assign(values.begin() + static_cast<std::ptrdiff_t>(i - n),
                      values.begin() + static_cast<std::ptrdiff_t>(i + n + 1));
        result[i] = median(around);
    }
    return result;
}

}  // namespace togishi
