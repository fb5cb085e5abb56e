// What the points of a cloud look like at an instant: light and opacity, which may change (model
// section 1.7).
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/surfel.h"

namespace SWEPT_API swept {

/// Whether looks may change between frames `first` and `last`.
[[nodiscard]] bool looks_change(const SurfelCloud& cloud, double first, double last);

/// Frames in ]first, last[ at which looks do not change evenly, increasing.
[[nodiscard]] std::vector<double> look_corners(const SurfelCloud& cloud, double first, double last);

/// Between which two looks of a cloud a frame is, and how far on from the first to the second. Both are the
/// same where looks are held.
struct LookPlace {
  std::size_t before = 0, after = 0;
  float share = 0.0f;
};
template <class Look>
[[nodiscard]] LookPlace look_place(const std::vector<Look>& looks, double frame) {
  const auto after = std::upper_bound(looks.begin(), looks.end(), frame,
                                      [](double f, const Look& look) { return f < look.frame; });
  if (after == looks.begin()) return {};
  const auto k = static_cast<std::size_t>(after - looks.begin());
  if (after == looks.end()) return {k - 1, k - 1, 0.0f};
  const double share = (frame - looks[k - 1].frame) / (looks[k].frame - looks[k - 1].frame);
  return {k - 1, k, static_cast<float>(share)};
}

/// Premultiplied RGBA of a cloud's points at a frame. The cloud must outlive it.
class LooksAt {
 public:
  LooksAt(const SurfelCloud& cloud, double frame);

  [[nodiscard]] Eigen::Vector4f operator[](std::size_t i) const {
    const Eigen::Vector4f from = look(first_, i);
    // A point equal in both keeps its bits.
    return share_ > 0.0f ? Eigen::Vector4f(from + share_ * (look(second_, i) - from)) : from;
  }

 private:
  struct Look {
    const PointArray<Eigen::Vector3f>* color;
    const PointArray<float>* opacity;
  };
  static Eigen::Vector4f look(const Look& of, std::size_t i) {
    const float opacity = of.opacity->empty() ? 1.0f : (*of.opacity)[i];
    Eigen::Vector4f rgba;
    rgba.head<3>() =
        opacity * (of.color->empty() ? Eigen::Vector3f(Eigen::Vector3f::Ones()) : (*of.color)[i]);
    rgba.w() = opacity;
    return rgba;
  }
  Look first_, second_;
  float share_ = 0.0f;
};

}  // namespace swept
