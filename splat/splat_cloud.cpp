#include "splat/splat_cloud.h"
#include "splat/without_throwing.h"

#include <cmath>
#include <cstdint>
#include <string>

namespace swept {
namespace {

[[nodiscard]] Error at(const char* array, std::size_t i, const std::string& reason) {
  return Error{"", std::string(array) + "[" + std::to_string(i) + "]", reason};
}

}  // namespace

Eigen::Vector3d SplatCloud::position_at(std::size_t splat, double at_frame) const {
  Eigen::Vector3d at = position[splat];
  if (!velocity.empty()) at += velocity[splat].cast<double>() * (at_frame - frame);
  if (!motion) return at;
  const double t = (at_frame - frame) / motion->frames - double{motion->center[splat]};
  const auto path = [&](std::size_t k) { return motion->path[splat][k].cast<double>(); };
  return at + t * (path(0) + t * (path(1) + t * path(2)));
}

Status SplatCloud::validate() const {
  return without_throwing("to check the splats", [&]() -> Status {
    const std::size_t n = size();
    if (degree < 0 || degree > 3) return Error{"", "degree", "must be in [0, 3]"};
    const auto wrong = [n](const char* array, std::size_t has, std::size_t expected) {
      return Error{"", array,
                   "has " + std::to_string(has) + " numbers for " + std::to_string(n) + " splats, not " +
                       std::to_string(expected)};
    };
    if (scale.size() != n) return wrong("scale", scale.size(), n);
    if (rotation.size() != n) return wrong("rotation", rotation.size(), n);
    if (opacity.size() != n) return wrong("opacity", opacity.size(), n);
    if (!velocity.empty() && velocity.size() != n) return wrong("velocity", velocity.size(), n);
    const std::size_t per_splat = 3 * static_cast<std::size_t>(coefficients(degree));
    if (harmonics.size() != n * per_splat) return wrong("harmonics", harmonics.size(), n * per_splat);
    if (motion && !velocity.empty())
      return Error{"", "motion", "goes without velocities: splats have either"};
    if (motion)
      if (Status s = motion->validate(n); !s) return Error{"", "motion/" + s.error().field, s.error().reason};
    if (!std::isfinite(frame)) return Error{"", "frame", "must be a finite number"};
    for (std::size_t i = 0; i < n; ++i) {
      if (!position[i].allFinite()) return at("position", i, "must be finite");
      if (!scale[i].allFinite() || scale[i].minCoeff() < 0.0f)
        return at("scale", i, "must be finite and not negative");
      if (!(std::abs(rotation[i].squaredNorm() - 1.0f) < 1e-4f))
        return at("rotation", i, "must have unit length");
      if (!(opacity[i] >= 0.0f && opacity[i] <= 1.0f)) return at("opacity", i, "must be in [0, 1]");
      if (!velocity.empty() && !velocity[i].allFinite()) return at("velocity", i, "must be finite");
    }
    for (std::size_t i = 0; i < harmonics.size(); ++i)
      if (!std::isfinite(harmonics[i])) return at("harmonics", i / per_splat, "must be finite");
    return Done{};
  });
}

}  // namespace swept
