#include "splat/surfel.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <utility>

#include <Eigen/Geometry>

#include "splat/motion/path.h"
#include "splat/without_throwing.h"

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

/// Rates that are all zero are looked at more than once in a render: in blocks, for the compiler to make
/// vectors of.
bool any_nonzero(const PointArray<Eigen::Vector3f>& rates) {
  constexpr std::size_t block = 4096;
  if (!rates.empty() && rates.contiguous()) {
    const float* numbers = rates[0].data();
    for (std::size_t first = 0, count = 3 * rates.size(); first < count; first += block) {
      std::uint32_t bits = 0;
      for (std::size_t k = first; k < std::min(count, first + block); ++k)
        bits |= std::bit_cast<std::uint32_t>(numbers[k]) << 1;  // −0 is 0
      if (bits != 0) return true;
    }
    return false;
  }
  return std::any_of(rates.begin(), rates.end(), [](const auto& rate) { return !rate.isZero(0.0f); });
}

/// Vectors that go with a single key.
Status check_rates(const std::string& name, const PointArray<Eigen::Vector3f>& rates,
                   const SurfelCloud& cloud) {
  if (rates.empty()) return Done{};
  if (cloud.keys.size() > 1) {
    return Error{"", name,
                 "belongs to a cloud with a single key, this one has " + std::to_string(cloud.keys.size())};
  }
  return check_vectors(name, rates, cloud.size());
}

/// Of `n` points; names begin with `of`.
Status check_look(const std::string& of, const PointArray<Eigen::Vector3f>& color,
                  const PointArray<float>& opacity, std::size_t n) {
  if (!color.empty()) {
    if (Status s = check_vectors(of + "color", color, n); !s) return s;
    for (std::size_t i = 0; i < color.size(); ++i)
      if (color[i].cwiseAbs().maxCoeff() > most_color)
        return Error{"", indexed(of + "color", i), "must lie in [-1e30, 1e30]"};
  }
  if (!opacity.empty() && opacity.size() != n) return wrong_count(of + "opacity", opacity.size(), n);
  for (std::size_t i = 0; i < opacity.size(); ++i) {
    // Written so that NaN fails it too.
    if (!(opacity[i] >= 0.0f && opacity[i] <= 1.0f))
      return Error{"", indexed(of + "opacity", i), "must lie in [0, 1]"};
  }
  return Done{};
}

}  // namespace

bool SurfelCloud::moves() const {
  return keys.size() > 1 || !lifetime.empty() || any_nonzero(velocity) || accelerates() || spins();
}

bool SurfelCloud::accelerates() const { return any_nonzero(acceleration); }

bool SurfelCloud::spins() const { return any_nonzero(angular_velocity); }

bool SurfelCloud::see_through() const {
  const auto lets_light_through = [](const PointArray<float>& opacities) {
    return std::any_of(opacities.begin(), opacities.end(), [](float o) { return o < 1.0f; });
  };
  if (looks.empty()) return lets_light_through(opacity);
  return std::any_of(looks.begin(), looks.end(),
                     [&](const LookKey& look) { return lets_light_through(look.opacity); });
}

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
    if (Status s = check_rates("velocity", velocity, *this); !s) return s;
    if (Status s = check_rates("acceleration", acceleration, *this); !s) return s;
    if (Status s = check_rates("angular_velocity", angular_velocity, *this); !s) return s;
    if (!lifetime.empty() && lifetime.size() != n) return wrong_count("lifetime", lifetime.size(), n);
    for (std::size_t i = 0; i < lifetime.size(); ++i) {
      if (!(lifetime[i].born <= lifetime[i].gone))
        return Error{"", indexed("lifetime", i), "must not end before it begins"};
    }
    if (Status s = check_look("", color, opacity, n); !s) return s;
    for (std::size_t k = 0; k < looks.size(); ++k) {
      const std::string name = indexed("looks", k);
      if (!std::isfinite(looks[k].frame)) return Error{"", name + ".frame", "is not finite"};
      if (k > 0 && !(looks[k - 1].frame < looks[k].frame))
        return Error{"", name + ".frame", "must come after the frame of the look before it"};
      if (Status s = check_look(name + ".", looks[k].color, looks[k].opacity, n); !s) return s;
    }
    if (!oriented.empty() && oriented.size() != n) return wrong_count("oriented", oriented.size(), n);
    return Done{};
  });
}

SurfelsAt::SurfelsAt(const SurfelCloud& cloud, double frame) : SurfelsAt(cloud, path_weights(cloud, frame)) {}

SurfelsAt::SurfelsAt(const SurfelCloud& cloud, PathWeights weights)
    : keys_(cloud.keys.data()), base_(&cloud.keys[weights.base].pose), weights_(std::move(weights)) {
  if (cloud.keys.size() > 1) return;
  if (!cloud.velocity.empty() && weights_.velocity != 0.0) velocity_ = &cloud.velocity;
  if (!cloud.acceleration.empty()) acceleration_ = &cloud.acceleration;
  if (!cloud.angular_velocity.empty() && weights_.elapsed != 0.0) spin_ = &cloud.angular_velocity;
}

void SurfelsAt::turn(const Eigen::Vector3f& rate, SurfelInstant& at) const {
  // Rates that are all zero cost a look.
  if (rate.isZero(0.0f)) return;
  const Eigen::Vector3d turns = rate.cast<double>() * weights_.elapsed;
  const double angle = turns.stableNorm();
  if (!(angle > 0.0)) return;
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(angle, turns / angle).toRotationMatrix();
  at.axis_u = rotation * at.axis_u;
  at.axis_v = rotation * at.axis_v;
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

Status shift_to_stamps(SurfelCloud& cloud, const std::vector<double>& stamps) {
  if (cloud.keys.size() > 1) return Error{"", "stamps", "belong to a cloud with a single key"};
  if (stamps.size() != cloud.size()) return wrong_count("stamps", stamps.size(), cloud.size());
  for (std::size_t i = 0; i < stamps.size(); ++i) {
    if (!std::isfinite(stamps[i])) return Error{"", indexed("stamps", i), "is not finite"};
    const double elapsed = cloud.keys.front().frame - stamps[i];
    if (elapsed == 0.0) continue;
    // The path from the stamp on, looked at when the key is.
    const SurfelsAt moved(cloud, {.base = 0,
                                  .others = {},
                                  .velocity = elapsed,
                                  .acceleration = 0.5 * elapsed * elapsed,
                                  .elapsed = elapsed});
    const SurfelInstant at = moved[i];
    SurfelPose& pose = cloud.keys.front().pose;
    pose.position[i] = at.position;
    pose.axis_u[i] = at.axis_u.cast<float>();
    pose.axis_v[i] = at.axis_v.cast<float>();
    bool finite = at.position.allFinite();
    if (!cloud.acceleration.empty()) {
      if (cloud.velocity.empty()) cloud.velocity.assign(cloud.size(), Eigen::Vector3f::Zero());
      cloud.velocity[i] =
          (cloud.velocity[i].cast<double>() + elapsed * cloud.acceleration[i].cast<double>()).cast<float>();
      finite = finite && cloud.velocity[i].allFinite();
    }
    if (!finite) return Error{"", indexed("stamps", i), "takes its point out of range"};
  }
  return Done{};
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
