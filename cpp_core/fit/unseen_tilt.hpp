// What a tilt that no scan shows does to the weight: it can only have lowered the peak.
#pragma once

namespace togishi {

struct Interval {
    double middle = 0, half = 0;
};

/// The shortest interval that holds 68.27 % of sigma g + drop z^2, with g and z standard normal:
/// the error of ln weight, and what a normal tilt z takes off the peak where one standard deviation
/// of it takes off `drop`. To a hundredth of its length. sigma > 0, drop >= 0.
[[nodiscard]] Interval interval_with_drop(double sigma, double drop);

}  // namespace togishi
