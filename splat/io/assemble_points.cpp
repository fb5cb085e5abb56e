#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>

#include "splat/io/attributes.h"
#include "splat/srgb.h"

namespace swept {
namespace {

using Values = std::vector<std::vector<double>>;

constexpr double kHarmonic0 = 0.28209479177387814;  // 1 / (2√π), the constant spherical harmonic

/// Up to this, linear values are in the range of float: 10^(16 · 2.4) / 1.055^2.4 = 2.2e38.
constexpr double largest_srgb = 1e16;

float linear_color(double stored, const Column& column) {
  if (column.full_scale == 0.0) return static_cast<float>(stored);
  return static_cast<float>(srgb_to_linear(stored / column.full_scale));
}

double fraction(double stored, const Column& column) {
  return column.full_scale == 0.0 ? stored : stored / column.full_scale;
}

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

/// Puts one point after the other into the set.
class Assembler {
 public:
  Assembler(const std::vector<Column>& columns, const AttributePlan& plan, const Values& values, double delta)
      : columns_(columns), plan_(plan), values_(values), cutoff_(std::sqrt(2.0 * delta)) {
    const std::vector<bool> needed = plan.needed(columns.size());
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
    if (const auto& channels = plan_.color ? plan_.color : plan_.harmonic) {
      for (const std::size_t c : *channels) {
        const double full_scale = columns_[c].full_scale;
        if (plan_.color && full_scale == 0.0) continue;  // linear already
        const double srgb = plan_.color ? values_[c][i] / full_scale : 0.5 + kHarmonic0 * values_[c][i];
        if (!(srgb <= largest_srgb)) return {{c, "is " + shown(values_[c][i]) + ", too large for a colour"}};
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
      const double o = fraction(values_[*c][i], columns_[*c]);
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
    if (!plan_.log_scale.empty()) {
      add_gaussian(i, set);
    } else if (plan_.radius) {
      set.radius.push_back(
          static_cast<float>(values_[*plan_.radius][i] * (plan_.radius_is_diameter ? 0.5 : 1.0)));
    }
    add_color(i, set);
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
        const std::size_t c = (*plan_.color)[k];
        return linear_color(values_[c][i], columns_[c]);
      };
      set.color.emplace_back(channel(0), channel(1), channel(2));
    } else if (plan_.harmonic) {
      const Eigen::Vector3d f = vector_at(values_, *plan_.harmonic, i);
      const auto channel = [&](Eigen::Index k) {
        return static_cast<float>(srgb_to_linear(std::max(0.0, 0.5 + kHarmonic0 * f[k])));
      };
      set.color.emplace_back(channel(0), channel(1), channel(2));
    }
    if (plan_.opacity) {
      const double stored = values_[*plan_.opacity][i];
      set.opacity.push_back(static_cast<float>(plan_.log_scale.empty()
                                                   ? fraction(stored, columns_[*plan_.opacity])
                                                   : 1.0 / (1.0 + std::exp(-stored))));
    } else if (plan_.alpha) {
      set.opacity.push_back(static_cast<float>(fraction(values_[*plan_.alpha][i], columns_[*plan_.alpha])));
    }
  }

  const std::vector<Column>& columns_;
  const AttributePlan& plan_;
  const Values& values_;
  double cutoff_;
  std::vector<std::size_t> used_;
};

constexpr std::uint32_t kDropped = std::numeric_limits<std::uint32_t>::max();

}  // namespace

Result<PointSet> assemble_points(const std::string& path, const std::vector<Column>& columns,
                                 const AttributePlan& plan, const Values& values,
                                 std::vector<std::array<std::uint32_t, 3>> triangles,
                                 const ReadOptions& options) {
  const std::size_t count = values[plan.position[0]].size();
  if (count == 0) return Error{path, "", "has no points"};
  if (count >= kDropped) return Error{path, "", "has more points than 32-bit indices can name"};
  if (!(options.delta > 0.0) || !std::isfinite(options.delta)) {
    return Error{"", "delta", "must be positive and finite"};
  }

  PointSet set;
  set.position.reserve(count);  // the largest of them
  const Assembler assembler(columns, plan, values, options.delta);
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

  set.triangle = std::move(triangles);
  if (const std::size_t dropped = count - set.size(); dropped > 0) {
    for (auto& triangle : set.triangle) {
      for (std::uint32_t& corner : triangle) corner = index_of[corner];
    }
    std::erase_if(set.triangle,
                  [](const auto& t) { return std::find(t.begin(), t.end(), kDropped) != t.end(); });
    set.notes.push_back("dropped " + std::to_string(dropped) + " of " + std::to_string(count) +
                        " points for numbers that are not finite");
  }
  if (plan.log_scale.size() == 3) set.notes.push_back("3D Gaussians: the shortest axis of each is dropped");
  return set;
}

}  // namespace swept
