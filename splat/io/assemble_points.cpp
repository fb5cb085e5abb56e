#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "splat/io/attributes.h"
#include "splat/io/color_scale.h"
#include "splat/srgb.h"

namespace swept {
namespace {

using Values = std::vector<std::vector<double>>;

constexpr double kHarmonic0 = 0.28209479177387814;  // 1 / (2√π), the constant spherical harmonic

/// Up to this, linear values are in the range of float: 10^(16 · 2.4) / 1.055^2.4 = 2.2e38.
constexpr double largest_srgb = 1e16;
constexpr double kMostFloat = std::numeric_limits<float>::max();

Eigen::Vector3d vector_at(const Values& values, const AttributePlan::Triple& c, std::size_t i) {
  return {values[c[0]][i], values[c[1]][i], values[c[2]][i]};
}

std::string shown(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

/// Ids of all points, if each has one that a double holds exactly and no other point has.
std::vector<std::int64_t> distinct_ids(const std::vector<double>& stored, std::string& why_not) {
  std::vector<std::int64_t> ids;
  ids.reserve(stored.size());
  for (const double value : stored) {
    if (!(std::abs(value) <= 0x1p53) || value != std::floor(value)) {
      why_not = "ids are not used: they are not all whole numbers up to 2^53";
      return {};
    }
    ids.push_back(static_cast<std::int64_t>(value));
  }
  std::vector<std::int64_t> sorted = ids;
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) return ids;
  why_not = "ids are not used: they repeat";
  return {};
}

/// Puts one point after the other into the set.
class Assembler {
 public:
  Assembler(const std::vector<Column>& columns, AttributePlan& plan, const Values& values,
            const ReadOptions& options, std::vector<std::string>& assumed)
      : plan_(plan), values_(values), cutoff_(std::sqrt(2.0 * options.delta)) {
    if (plan.color) {
      scale_ = color_scale(columns, *plan.color, values, options);
      assumed.push_back(scale_.assumed);
    } else if (plan.intensity) {
      const auto grey = grey_scale(columns[*plan.intensity], values[*plan.intensity], options);
      if (grey) {
        scale_ = *grey;
        assumed.push_back(grey->assumed);
        const auto& stored = values[*plan.intensity];
        const auto lost =
            std::count_if(stored.begin(), stored.end(), [](double v) { return !std::isfinite(v); });
        if (lost > 0) assumed.push_back(std::to_string(lost) + " intensities that are not finite are black");
      } else {
        assumed.push_back("intensities are not used: some are negative (color_range says what full is)");
        plan.intensity.reset();
      }
    }
    if (!plan.log_scale.empty()) {
      assumed.push_back(std::string("Gaussian splats: scales are logarithms, opacities logits") +
                        (plan.harmonic ? ", colours the first spherical harmonic, sRGB" : ""));
    }
    for (const auto& c : {plan.opacity, plan.alpha}) {
      if (c) alpha_full_ = alpha_full(columns[*c], values[*c], c == plan.alpha ? scale_.full : 1.0);
    }
    if (plan.id) {
      std::string why_not;
      ids_ = distinct_ids(values[*plan.id], why_not);
      if (!why_not.empty()) assumed.push_back(why_not);
      if (ids_.empty()) plan.id.reset();
    }
    std::vector<bool> needed = plan.needed(columns.size());
    if (plan.intensity) needed[*plan.intensity] = false;  // black where it is not finite
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (needed[c]) used_.push_back(c);
    }
  }

  /// What is wrong with point i: column and reason.
  [[nodiscard]] std::optional<std::pair<std::size_t, std::string>> fault(std::size_t i) const {
    for (const std::size_t c : used_) {
      // What float cannot hold would become infinite further on.
      if (!(std::abs(values_[c][i]) <= std::numeric_limits<float>::max())) {
        return {{c, "is " + shown(values_[c][i]) + ", not a finite number in the range of float"}};
      }
    }
    if (plan_.color) {
      for (const std::size_t c : *plan_.color) {
        const double most = scale_.space == ColorSpace::srgb ? largest_srgb : kMostFloat;
        if (!(std::abs(scale_.channel(values_[c][i])) <= most))
          return {{c, "is " + shown(values_[c][i]) + ", too large for a colour"}};
      }
    } else if (plan_.harmonic) {
      for (const std::size_t c : *plan_.harmonic) {
        if (!(0.5 + kHarmonic0 * values_[c][i] <= largest_srgb))
          return {{c, "is " + shown(values_[c][i]) + ", too large for a colour"}};
      }
    }
    for (const std::size_t c : plan_.log_scale) {
      if (!(std::exp(values_[c][i]) * cutoff_ <= std::numeric_limits<float>::max())) {
        return {{c, "is " + shown(values_[c][i]) + ", too large for the logarithm of a scale"}};
      }
    }
    if (!plan_.log_scale.empty() && !(quaternion(i).coeffs().stableNorm() > 0.0)) {
      return {{plan_.quaternion[0], "starts a quaternion of length zero"}};
    }
    return std::nullopt;
  }

  /// Numbers that are wrong however finite: these are errors even where invalid points are skipped.
  [[nodiscard]] std::optional<std::pair<std::size_t, std::string>> out_of_range(std::size_t i) const {
    if (plan_.radius && values_[*plan_.radius][i] < 0.0) {
      return {{*plan_.radius, "is " + shown(values_[*plan_.radius][i]) + ", must not be negative"}};
    }
    if (!plan_.log_scale.empty()) return std::nullopt;
    for (const auto& c : {plan_.opacity, plan_.alpha}) {
      if (!c) continue;
      const double o = values_[*c][i] / alpha_full_;
      if (!(o >= 0.0 && o <= 1.0)) return {{*c, "is " + shown(o) + ", must lie in [0, 1]"}};
    }
    return std::nullopt;
  }

  void add(std::size_t i, PointSet& set) const {
    set.position.push_back(vector_at(values_, plan_.position, i));
    if (plan_.normal) {
      // stableNormalized: zero stays zero, and the squares of tiny components do not vanish.
      set.normal.push_back(vector_at(values_, *plan_.normal, i).stableNormalized().cast<float>());
    }
    if (plan_.velocity) set.velocity.push_back(vector_at(values_, *plan_.velocity, i).cast<float>());
    if (plan_.acceleration)
      set.acceleration.push_back(vector_at(values_, *plan_.acceleration, i).cast<float>());
    if (plan_.angular_velocity)
      set.angular_velocity.push_back(vector_at(values_, *plan_.angular_velocity, i).cast<float>());
    if (plan_.time) set.time.push_back(values_[*plan_.time][i]);
    if (!plan_.log_scale.empty()) {
      add_gaussian(i, set);
    } else if (plan_.radius) {
      set.radius.push_back(
          static_cast<float>(values_[*plan_.radius][i] * (plan_.radius_is_diameter ? 0.5 : 1.0)));
    }
    add_color(i, set);
    if (!ids_.empty()) set.id.push_back(ids_[i]);
  }

 private:
  [[nodiscard]] Eigen::Quaterniond quaternion(std::size_t i) const {
    const auto& q = plan_.quaternion;
    return {values_[q[0]][i], values_[q[1]][i], values_[q[2]][i], values_[q[3]][i]};
  }

  void add_gaussian(std::size_t i, PointSet& set) const {
    // stableNormalized: the squares of tiny components do not vanish.
    const Eigen::Quaterniond turn(quaternion(i).coeffs().stableNormalized());
    const Eigen::Matrix3d rotation = turn.toRotationMatrix();
    std::size_t u = 0, v = 1;
    if (plan_.log_scale.size() == 3) {
      std::size_t shortest = 2;
      for (const std::size_t k : {std::size_t{1}, std::size_t{0}}) {
        if (values_[plan_.log_scale[k]][i] < values_[plan_.log_scale[shortest]][i]) shortest = k;
      }
      u = (shortest + 1) % 3;  // cyclic, so that a₁ × a₂ is the axis left out
      v = (shortest + 2) % 3;
    }
    const auto axis = [&](std::size_t k) -> Eigen::Vector3f {
      return (rotation.col(static_cast<Eigen::Index>(k)) *
              (std::exp(values_[plan_.log_scale[k]][i]) * cutoff_))
          .cast<float>();
    };
    set.axis_u.push_back(axis(u));
    set.axis_v.push_back(axis(v));
  }

  void add_color(std::size_t i, PointSet& set) const {
    if (plan_.color) {
      const auto channel = [&](std::size_t k) {
        return static_cast<float>(scale_.linear(values_[(*plan_.color)[k]][i]));
      };
      set.color.emplace_back(channel(0), channel(1), channel(2));
    } else if (plan_.harmonic) {
      const Eigen::Vector3d f = vector_at(values_, *plan_.harmonic, i);
      const auto channel = [&](Eigen::Index k) {
        return static_cast<float>(srgb_to_linear(std::max(0.0, 0.5 + kHarmonic0 * f[k])));
      };
      set.color.emplace_back(channel(0), channel(1), channel(2));
    }
    if (plan_.intensity) {
      const double stored = values_[*plan_.intensity][i];
      const double grey = std::isfinite(stored) ? std::clamp(scale_.linear(stored), 0.0, kMostFloat) : 0.0;
      set.color.push_back(Eigen::Vector3f::Constant(static_cast<float>(grey)));
    }
    if (plan_.opacity) {
      const double stored = values_[*plan_.opacity][i];
      set.opacity.push_back(static_cast<float>(plan_.log_scale.empty() ? stored / alpha_full_
                                                                       : 1.0 / (1.0 + std::exp(-stored))));
    } else if (plan_.alpha) {
      set.opacity.push_back(static_cast<float>(values_[*plan_.alpha][i] / alpha_full_));
    }
  }

  const AttributePlan& plan_;
  const Values& values_;
  double cutoff_;
  ColorScale scale_;
  double alpha_full_ = 1.0;
  std::vector<std::int64_t> ids_;
  std::vector<std::size_t> used_;
};

constexpr std::uint32_t kDropped = std::numeric_limits<std::uint32_t>::max();

}  // namespace

Result<PointSet> assemble_points(const std::string& path, const std::vector<Column>& columns,
                                 const AttributePlan& plan, const Values& values,
                                 std::vector<std::array<std::uint32_t, 3>> triangles,
                                 const ReadOptions& options, std::vector<TextureCorners> corners) {
  const std::size_t count = values[plan.position[0]].size();
  if (count == 0) return Error{path, "", "has no points", ErrorKind::empty};
  if (count >= kDropped)
    return Error{path, "", "has more points than 32-bit indices can name", ErrorKind::unsupported};
  if (!(options.delta > 0.0) || !std::isfinite(options.delta)) {
    return Error{"", "delta", "must be positive and finite"};
  }

  if (options.color_range && (!(*options.color_range > 0.0) || !std::isfinite(*options.color_range))) {
    return Error{"", "color_range", "must be positive and finite"};
  }

  PointSet set;
  set.position.reserve(count);  // the largest of them
  AttributePlan used = plan;
  std::vector<std::string> assumed;
  const Assembler assembler(columns, used, values, options, assumed);
  std::vector<std::uint32_t> index_of(count, kDropped);
  for (std::size_t i = 0; i < count; ++i) {
    const auto invalid = assembler.fault(i);
    if (invalid && options.skip_invalid) continue;
    if (const auto wrong = invalid ? invalid : assembler.out_of_range(i)) {
      return Error{path, columns[wrong->first].name, "point " + std::to_string(i) + " " + wrong->second};
    }
    index_of[i] = static_cast<std::uint32_t>(set.size());
    assembler.add(i, set);
  }
  if (set.size() == 0) return Error{path, "", "has no point with finite numbers"};

  set.report = used.report(columns);
  set.report.assumed = std::move(assumed);
  set.report.points = count;
  set.report.dropped = count - set.size();
  set.triangle = std::move(triangles);
  set.texture_corners = std::move(corners);
  if (const std::size_t dropped = count - set.size(); dropped > 0) {
    for (auto& triangle : set.triangle) {
      for (std::uint32_t& corner : triangle) corner = index_of[corner];
    }
    const auto lost = [](const auto& t) { return std::find(t.begin(), t.end(), kDropped) != t.end(); };
    std::size_t kept = 0;
    for (std::size_t t = 0; t < set.texture_corners.size(); ++t)
      if (!lost(set.triangle[t])) set.texture_corners[kept++] = set.texture_corners[t];
    set.texture_corners.resize(kept);
    std::erase_if(set.triangle, lost);
    set.notes.push_back("dropped " + std::to_string(dropped) + " of " + std::to_string(count) +
                        " points for numbers that are not finite, or too large");
  }
  if (plan.log_scale.size() == 3) set.notes.push_back("3D Gaussians: the shortest axis of each is dropped");
  return set;
}

}  // namespace swept
