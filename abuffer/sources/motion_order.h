// An order for points that move apart, so that those of a packet stay together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace swept {

/// Where a point is when the exposure begins and when it ends: x, y, z each.
using PointEnds = Eigen::Matrix<double, 6, 1>;

/// `order` again where its packets of sixteen, each in a row, stay together as they are; else one whose
/// packets are small at both ends: all points are halved where they are spread most, and so are the halves.
/// Points of equal coordinates follow each other by `less`.
[[nodiscard]] std::vector<std::uint32_t> motion_order(
    std::vector<std::uint32_t> order, const std::function<PointEnds(std::uint32_t)>& ends,
    const std::function<bool(std::uint32_t, std::uint32_t)>& less);

}  // namespace swept
