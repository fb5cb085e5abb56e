#include "splat/splat_motion.h"

#include <cmath>
#include <string>

#include "splat/splat_cloud.h"

namespace swept {

Status SplatMotion::validate(std::size_t splats) const {
  const auto wrong = [splats](const char* array, std::size_t has) {
    return Error{"", array,
                 "has " + std::to_string(has) + " numbers for " + std::to_string(splats) + " splats"};
  };
  if (center.size() != splats) return wrong("center", center.size());
  if (duration.size() != splats) return wrong("duration", duration.size());
  if (path.size() != splats) return wrong("path", path.size());
  if (turn.size() != splats) return wrong("turn", turn.size());
  if (!(frames > 0.0) || !std::isfinite(frames)) return Error{"", "frames", "must be finite and above 0"};
  for (std::size_t i = 0; i < splats; ++i) {
    const auto at = [i](const char* array, const char* reason) {
      return Error{"", std::string(array) + "[" + std::to_string(i) + "]", reason};
    };
    if (!std::isfinite(center[i])) return at("center", "must be finite");
    if (!(duration[i] > 0.0f) || !std::isfinite(duration[i]))
      return at("duration", "must be finite and above 0");
    for (const Eigen::Vector3f& coefficient : path[i])
      if (!coefficient.allFinite()) return at("path", "must be finite");
    if (!turn[i].allFinite()) return at("turn", "must be finite");
  }
  return Done{};
}

SplatCloud splats_at(const SplatCloud& cloud, const SplatMotion& motion, double time) {
  SplatCloud now = cloud;
  now.velocity.clear();
  now.motion.reset();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double t = time - static_cast<double>(motion.center[i]);
    const auto path = [&](std::size_t k) { return motion.path[i][k].cast<double>(); };
    now.position[i] += t * (path(0) + t * (path(1) + t * path(2)));
    const Eigen::Vector4d turn = t * motion.turn[i].cast<double>();
    const Eigen::Vector4d coeffs =
        cloud.rotation[i].coeffs().cast<double>() + Eigen::Vector4d(turn[1], turn[2], turn[3], turn[0]);
    if (coeffs.allFinite() && coeffs.stableNorm() > 0.0)
      now.rotation[i].coeffs() = coeffs.stableNormalized().cast<float>();
    const double share = t / static_cast<double>(motion.duration[i]);
    now.opacity[i] = static_cast<float>(static_cast<double>(cloud.opacity[i]) * std::exp(-share * share));
  }
  return now;
}

}  // namespace swept
