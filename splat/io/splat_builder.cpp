#include "splat/io/splat_builder.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace swept::io {
namespace {

std::string shown(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0.0 ? "inf" : "-inf";
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

bool fits(double value) { return std::abs(value) <= std::numeric_limits<float>::max(); }

}  // namespace

double opacity_of_logit(double logit) { return 1.0 / (1.0 + std::exp(-logit)); }

Status may_hold(std::size_t packed, std::size_t splats, int degree) {
  constexpr std::size_t always = std::size_t{64} << 20, likely = 64;
  const std::size_t each =
      sizeof(Eigen::Vector3d) + sizeof(Eigen::Vector3f) + sizeof(Eigen::Quaternionf) +
      sizeof(float) * (1 + 3 * static_cast<std::size_t>(SplatCloud::coefficients(degree)));
  if (splats <= always / each || splats / likely <= packed / each) return Done{};
  return Error{"", "",
               "promises " + std::to_string(splats) + " splats, which take more than " +
                   std::to_string(likely) + " times the " + std::to_string(packed) +
                   " bytes that they are packed in"};
}

SplatBuilder::SplatBuilder(const std::string& path, std::size_t count, int degree, bool velocities,
                           const SplatReadOptions& options, SplatNames names)
    : path_(path),
      harmonics_(static_cast<std::size_t>(SplatCloud::coefficients(degree))),
      velocities_(velocities),
      skip_invalid_(options.skip_invalid),
      names_(std::move(names)) {
  SplatCloud& cloud = loaded.splats;
  cloud.degree = degree;
  cloud.position.reserve(count);
  cloud.scale.reserve(count);
  cloud.rotation.reserve(count);
  cloud.opacity.reserve(count);
  cloud.harmonics.reserve(count * 3 * harmonics_);
  if (velocities) cloud.velocity.reserve(count);
}

bool SplatBuilder::find_fault(const SplatRow& row, Fault& fault) const {
  const auto not_finite = [&](SplatPart part, const auto& numbers) {
    for (std::size_t k = 0; k < static_cast<std::size_t>(numbers.size()); ++k) {
      const double value = numbers[static_cast<Eigen::Index>(k)];
      if (fits(value)) continue;
      fault = {part, k, "is " + shown(value) + ", not a finite number in the range of float", true};
      return true;
    }
    return false;
  };
  if (not_finite(SplatPart::position, row.position)) return true;
  for (std::size_t k = 0; k < 3; ++k) {
    const double scale = row.scale[static_cast<Eigen::Index>(k)];
    if (fits(scale) && scale >= 0.0) continue;
    fault = {SplatPart::scale, k,
             scale < 0.0 ? "is " + shown(scale) + ", must not be negative"
                         : "gives a standard deviation of " + shown(scale) + ", beyond the range of float",
             !(scale < 0.0)};
    return true;
  }
  if (not_finite(SplatPart::rotation, row.rotation)) return true;
  if (!(row.rotation.stableNorm() > 0.0)) {
    fault = {SplatPart::rotation, 0, "starts a quaternion of length zero", true};
    return true;
  }
  if (!(row.opacity >= 0.0 && row.opacity <= 1.0)) {
    fault = {SplatPart::opacity, 0, "is " + shown(row.opacity) + ", must lie in [0, 1]",
             std::isnan(row.opacity)};
    return true;
  }
  for (std::size_t k = 0; k < harmonics_; ++k) {
    if (!not_finite(SplatPart::harmonics, row.harmonics[k])) continue;
    fault.component += 3 * k;
    return true;
  }
  return velocities_ && not_finite(SplatPart::velocity, row.velocity);
}

Status SplatBuilder::add(const SplatRow& row) {
  if (Fault fault; find_fault(row, fault)) {
    const std::string field = names_(fault.part, fault.component);
    if (fault.invalid) return drop(field, fault.reason);
    return Error{path_, field, "splat " + std::to_string(added_) + " " + fault.reason};
  }
  ++added_;
  SplatCloud& cloud = loaded.splats;
  cloud.position.push_back(row.position);
  cloud.scale.push_back(row.scale.cast<float>());
  // stableNormalized: the squares of tiny components do not vanish.
  const Eigen::Vector4f q = row.rotation.stableNormalized().cast<float>();
  cloud.rotation.emplace_back(q[0], q[1], q[2], q[3]);
  cloud.opacity.push_back(static_cast<float>(row.opacity));
  for (std::size_t k = 0; k < harmonics_; ++k)
    for (Eigen::Index channel = 0; channel < 3; ++channel)
      cloud.harmonics.push_back(static_cast<float>(row.harmonics[k][channel]));
  if (velocities_) cloud.velocity.push_back(row.velocity.cast<float>());
  return Done{};
}

Status SplatBuilder::drop(const std::string& field, const std::string& reason) {
  const std::size_t index = added_++;
  if (skip_invalid_) return Done{};
  return Error{path_, field, "splat " + std::to_string(index) + " " + reason};
}

Result<LoadedSplats> SplatBuilder::finish() {
  const std::size_t kept = loaded.splats.size();
  if (added_ == 0) return Error{path_, "", "has no splats", ErrorKind::empty};
  if (kept == 0) return Error{path_, "", "has no splat with finite numbers"};
  loaded.report.points = added_;
  loaded.report.dropped = added_ - kept;
  if (kept < added_)
    loaded.notes.push_back("dropped " + std::to_string(added_ - kept) + " of " + std::to_string(added_) +
                           " splats for numbers that are not finite");
  return std::move(loaded);
}

}  // namespace swept::io
