#include "splat/surfel.h"
#include "splat/without_throwing.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <Eigen/Geometry>

namespace swept {
namespace {

std::string indexed(const std::string& array, std::size_t i) { return array + "[" + std::to_string(i) + "]"; }

Error wrong_count(const std::string& array, std::size_t found, std::size_t expected) {
  return {"", array,
          "has " + std::to_string(found) + " entries where the cloud has " + std::to_string(expected) +
              " points"};
}

/// Count and finiteness of an array of fixed-size vectors.
template <class Vector>
Status check_vectors(const std::string& name, const PointArray<Vector>& array, std::size_t expected) {
  if (array.size() != expected) return wrong_count(name, array.size(), expected);
  for (std::size_t i = 0; i < array.size(); ++i) {
    if (!array[i].allFinite()) return Error{"", indexed(name, i), "is not finite"};
  }
  return Done{};
}

Status check_pose(const std::string& name, const SurfelPose& pose, std::size_t expected) {
  if (Status s = check_vectors(name + ".position", pose.position, expected); !s) return s;
  if (Status s = check_vectors(name + ".axis_u", pose.axis_u, expected); !s) return s;
  return check_vectors(name + ".axis_v", pose.axis_v, expected);
}

}  // namespace

Status SurfelCloud::validate() const {
  return without_throwing("to check the points", [&]() -> Status {
    const std::size_t n = size();
    for (std::size_t k = 0; k < keys.size(); ++k) {
      const std::string name = indexed("keys", k);
      if (!std::isfinite(keys[k].frame)) return Error{"", name + ".frame", "is not finite"};
      if (k > 0 && !(keys[k - 1].frame < keys[k].frame)) {
        return Error{"", name + ".frame", "must come after the frame of the key before it"};
      }
      if (Status s = check_pose(name + ".pose", keys[k].pose, n); !s) return s;
    }
    if (!velocity.empty()) {
      if (keys.size() > 1) {
        return Error{"", "velocity",
                     "belongs to a cloud with a single key, this one has " + std::to_string(keys.size())};
      }
      if (Status s = check_vectors("velocity", velocity, n); !s) return s;
    }
    if (!color.empty()) {
      if (Status s = check_vectors("color", color, n); !s) return s;
      for (std::size_t i = 0; i < color.size(); ++i)
        if (color[i].cwiseAbs().maxCoeff() > most_color)
          return Error{"", indexed("color", i), "must lie in [-1e30, 1e30]"};
    }
    if (!opacity.empty() && opacity.size() != n) return wrong_count("opacity", opacity.size(), n);
    for (std::size_t i = 0; i < opacity.size(); ++i) {
      // Written so that NaN fails it too.
      if (!(opacity[i] >= 0.0f && opacity[i] <= 1.0f)) {
        return Error{"", indexed("opacity", i), "must lie in [0, 1]"};
      }
    }
    if (!oriented.empty() && oriented.size() != n) return wrong_count("oriented", oriented.size(), n);
    return Done{};
  });
}

SurfelsAt::SurfelsAt(const SurfelCloud& cloud, double frame) : before_(&cloud.keys.front().pose) {
  const std::vector<SurfelKey>& keys = cloud.keys;
  if (keys.size() == 1) {
    if (!cloud.velocity.empty()) velocity_ = &cloud.velocity;
    elapsed_ = frame - keys.front().frame;
    return;
  }
  const auto after = std::upper_bound(keys.begin(), keys.end(), frame,
                                      [](double f, const SurfelKey& key) { return f < key.frame; });
  if (after == keys.begin()) return;
  before_ = &(after - 1)->pose;
  if (after == keys.end()) return;
  after_ = &after->pose;
  t_ = (frame - (after - 1)->frame) / (after->frame - (after - 1)->frame);
}

SurfelInstant surfel_at(const SurfelCloud& cloud, std::size_t i, double frame) {
  assert(i < cloud.size());
  return SurfelsAt(cloud, frame)[i];
}

void round_disc(const Eigen::Vector3d& normal, double radius, Eigen::Vector3f& axis_u,
                Eigen::Vector3f& axis_v) {
  const Eigen::Vector3d n = normal.stableNormalized(), u = n.unitOrthogonal();
  axis_u = (radius * u).cast<float>();
  axis_v = (radius * n.cross(u)).cast<float>();
}

void align_axes(const SurfelPose& reference, SurfelPose& moving) {
  assert(reference.size() == moving.size());
  for (std::size_t i = 0; i < moving.size(); ++i) {
    const Eigen::Vector3d ru = reference.axis_u[i].cast<double>(), rv = reference.axis_v[i].cast<double>();
    const Eigen::Vector3d mu = moving.axis_u[i].cast<double>(), mv = moving.axis_v[i].cast<double>();
    // |M R(θ) − B|² is least where cos θ tr(MᵀB) + sin θ ((MᵀB)₁₀ − (MᵀB)₀₁) is greatest.
    const double cosine = mu.dot(ru) + mv.dot(rv), sine = mv.dot(ru) - mu.dot(rv);
    const double length = std::hypot(cosine, sine);
    if (!(length > 0.0)) continue;  // every rotation is as good
    const double c = cosine / length, s = sine / length;
    moving.axis_u[i] = (c * mu + s * mv).cast<float>();
    moving.axis_v[i] = (c * mv - s * mu).cast<float>();
  }
}

}  // namespace swept
