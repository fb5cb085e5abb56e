// One geometry of Embree's for every stretch of time that segments cover, and one primitive for every
// segment: motion is linear within it, and so its box may be blended from those at the two ends. Volumes and
// their traversal are Embree's, the intersection with a disc is ours and in double precision.
#include "tools/study/disc_volumes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <new>
#include <string>
#include <tuple>
#include <utility>

#include <embree3/rtcore.h>

#include "abuffer/parallel.h"
#include "splat/kernel/ray_kernel.h"

namespace swept {
namespace {

using Eigen::Vector3d;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// Embree leaves out what reaches beyond 1.8·10¹⁸.
constexpr double kFarthest = 1e18;

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using Device = std::unique_ptr<RTCDeviceTy, Release>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, Release>;
using Geometry = std::unique_ptr<RTCGeometryTy, Release>;

/// What all rays share.
struct RayModel {
  double near, delta;
  bool opaque = true;           ///< all discs are
  float saturating_rho = 0.0f;  ///< of a hit that alone covers the pixel
  float reach =
      0.0f;  ///< how far behind any of its discs a surface goes at most, as its nearest one tolerates

  RayModel(const KernelSet& set, const ImageModel& model) : near(set.near), delta(model.delta) {
    if (model.coverage == Coverage::soft) saturating_rho = static_cast<float>(model.edge_weight);
    for (const MovingKernel& kernel : set.kernels) {
      opaque = opaque && kernel.color.w() >= 1.0f;
      reach = std::max(reach, kernel.depth_tolerance +
                                  std::abs(kernel.tolerance_rate) * static_cast<float>(kernel.half_time()));
    }
  }

  /// The depth beyond which nothing is seen behind a hit.
  [[nodiscard]] float horizon(const Hit& hit) const {
    return opaque && hit.rho >= saturating_rho ? hit.z + reach : kInfinity;
  }
};

/// A kernel as rays meet it.
struct Primitive {
  Primitive(const MovingKernel& k, std::uint32_t index)
      : plane(k), weight(k.weight), t_begin(k.t_begin), t_end(k.t_end), kernel(index) {}

  KernelPlane<double> plane;
  float weight, t_begin, t_end;
  std::uint32_t kernel;
};

/// Boxes of a disc as its segment begins and ends: Embree asks for them many times over.
using Boxes = std::array<RTCBounds, 2>;

/// The kernels of one stretch of time.
struct Group {
  float t_begin, t_end;
  bool still;
  std::vector<Primitive> primitives;
  std::vector<Boxes> boxes;
};

/// What Embree hands to the callback: the address of its first member.
struct Query {
  RTCIntersectContext context;
  const RayModel* model;
  const DiscRay* ray;
  std::vector<Hit>* hits;
  bool out_of_memory;
};

Vector3d center_at(const MovingKernel& kernel, float time) {
  return kernel.center + (static_cast<double>(time) - static_cast<double>(kernel.t_mid())) * kernel.velocity;
}

Vector3d half_extent(const MovingKernel& kernel) {
  return (kernel.axis_u.cast<double>().array().square() + kernel.axis_v.cast<double>().array().square())
      .sqrt();
}

/// Of the disc at either end of its segment.
double largest_coordinate(const MovingKernel& kernel) {
  const Vector3d half = half_extent(kernel);
  return std::max((center_at(kernel, kernel.t_begin).cwiseAbs() + half).maxCoeff(),
                  (center_at(kernel, kernel.t_end).cwiseAbs() + half).maxCoeff());
}

RTCBounds box_at(const MovingKernel& kernel, float time) {
  const Vector3d center = center_at(kernel, time);
  // Corners, the ray's direction and the blend of the two boxes are single precision: off by a few 2⁻²⁴ of
  // the largest coordinate each.
  const Vector3d half = half_extent(kernel).array() + 0x1p-20 * largest_coordinate(kernel);
  const Eigen::Vector3f low = (center - half).cast<float>(), high = (center + half).cast<float>();
  return {low.x(), low.y(), low.z(), 0.0f, high.x(), high.y(), high.z(), 0.0f};
}

void bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& group = *static_cast<const Group*>(arguments->geometryUserPtr);
  *arguments->bounds_o = group.boxes[arguments->primID][arguments->timeStep];
}

void intersect(const RTCIntersectFunctionNArguments* arguments) {
  if (arguments->valid[0] == 0) return;
  const auto& group = *static_cast<const Group*>(arguments->geometryUserPtr);
  const Primitive& primitive = group.primitives[arguments->primID];
  Query& query = *reinterpret_cast<Query*>(arguments->context);
  const RayModel& model = *query.model;
  const DiscRay& ray = *query.ray;

  // Half open, so that of two segments that meet one is seen.
  if (!(ray.time >= primitive.t_begin && ray.time < primitive.t_end)) return;
  if (!primitive.plane.faces(ray.x, ray.y)) return;
  const RayCoordinates<double> middle = primitive.plane.along(ray.x, ray.y);
  const double t_mid = 0.5 * (static_cast<double>(primitive.t_begin) + static_cast<double>(primitive.t_end));
  const double elapsed = static_cast<double>(ray.time) - t_mid;
  const double u = middle.u + middle.du * elapsed, v = middle.v + middle.dv * elapsed;
  const double squared = u * u + v * v, z = middle.z + middle.dz * elapsed;
  // A coordinate that is not a number, as of a disc edge-on, fails.
  if (!(squared <= 1.0 && z >= model.near && z <= kFarthest)) return;
  const double rho = static_cast<double>(primitive.weight) * std::exp(-model.delta * squared);
  const Hit hit{static_cast<float>(z), static_cast<float>(rho), primitive.kernel};
  if (!(hit.rho > 0.0f)) return;
  try {
    query.hits->push_back(hit);
  } catch (const std::bad_alloc&) {
    query.out_of_memory = true;  // nothing may be thrown through Embree
  }
  // Volumes that begin beyond are passed over.
  float& tfar = reinterpret_cast<RTCRayHit*>(arguments->rayhit)->ray.tfar;  // single rays only
  tfar = std::min(tfar, std::nextafter(model.horizon(hit), kInfinity));
}

/// What does not move needs no volumes that do.
std::vector<Group> grouped(const KernelSet& set) {
  std::map<std::tuple<float, float, bool>, std::size_t> places;
  std::vector<Group> groups;
  for (std::size_t k = 0; k < set.kernels.size(); ++k) {
    const MovingKernel& kernel = set.kernels[k];
    const auto [place, added] =
        places.try_emplace({kernel.t_begin, kernel.t_end, kernel.still()}, groups.size());
    if (added) groups.push_back({kernel.t_begin, kernel.t_end, kernel.still(), {}, {}});
    Group& group = groups[place->second];
    group.primitives.emplace_back(kernel, static_cast<std::uint32_t>(k));
    group.boxes.push_back({box_at(kernel, kernel.t_begin), box_at(kernel, kernel.t_end)});
  }
  return groups;
}

}  // namespace

struct DiscVolumes::Parts {
  RayModel model;
  std::vector<Group> groups;
  Device device;
  EmbreeScene scene;

  void add(Group& group) {
    const Geometry geometry(rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_USER));
    rtcSetGeometryUserPrimitiveCount(geometry.get(), static_cast<unsigned>(group.primitives.size()));
    rtcSetGeometryUserData(geometry.get(), &group);
    if (!group.still) {
      rtcSetGeometryTimeStepCount(geometry.get(), 2);
      rtcSetGeometryTimeRange(geometry.get(), group.t_begin, group.t_end);
    }
    rtcSetGeometryBoundsFunction(geometry.get(), bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry.get(), intersect);
    rtcCommitGeometry(geometry.get());
    rtcAttachGeometry(scene.get(), geometry.get());
  }
};

DiscVolumes::DiscVolumes(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
DiscVolumes::DiscVolumes(DiscVolumes&&) noexcept = default;
DiscVolumes& DiscVolumes::operator=(DiscVolumes&&) noexcept = default;
DiscVolumes::~DiscVolumes() = default;

Result<DiscVolumes> DiscVolumes::build(const KernelSet& set, const ImageModel& model, int threads) {
  for (const MovingKernel& kernel : set.kernels) {
    if (!(largest_coordinate(kernel) <= kFarthest))
      return Error{"", "", "a disc is farther than 10^18 units, where Embree sees nothing"};
  }
  // Embree's threads fill its trees by oneTBB, unseen; they end here, and rays are cast by ours.
  if (thread_sanitizer) threads = 1;
  const std::string settings = threads > 0 ? "threads=" + std::to_string(threads) : "";
  auto parts = std::unique_ptr<Parts>(
      new Parts{RayModel(set, model), grouped(set), Device(rtcNewDevice(settings.c_str())), {}});
  if (!parts->device) return Error{"", "", "Embree does not start on this machine"};
  parts->scene.reset(rtcNewScene(parts->device.get()));
  rtcSetSceneBuildQuality(parts->scene.get(), RTC_BUILD_QUALITY_HIGH);
  rtcSetSceneFlags(parts->scene.get(), RTC_SCENE_FLAG_ROBUST);
  for (Group& group : parts->groups) parts->add(group);
  rtcCommitScene(parts->scene.get());
  switch (rtcGetDeviceError(parts->device.get())) {
    case RTC_ERROR_NONE:
      return DiscVolumes(std::move(parts));
    case RTC_ERROR_OUT_OF_MEMORY:
      throw std::bad_alloc();
    default:
      return Error{"", "", "Embree failed to build its bounding volumes"};
  }
}

std::size_t DiscVolumes::meet(const DiscRay& ray, std::vector<Hit>& hits) const {
  hits.clear();
  Query query{{}, &parts_->model, &ray, &hits, false};
  rtcInitIntersectContext(&query.context);
  RTCRayHit traced{};
  traced.ray.dir_x = static_cast<float>(ray.x);
  traced.ray.dir_y = static_cast<float>(ray.y);
  traced.ray.dir_z = 1.0f;  // so that the distance along the ray is depth
  traced.ray.tfar = kInfinity;
  traced.ray.time = ray.time;
  traced.ray.mask = ~0u;
  traced.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(parts_->scene.get(), &query.context, &traced);
  if (query.out_of_memory) throw std::bad_alloc();

  std::sort(hits.begin(), hits.end(),
            [](const Hit& a, const Hit& b) { return a.z != b.z ? a.z < b.z : a.kernel < b.kernel; });
  const std::size_t met = hits.size();
  float horizon = kInfinity;
  std::size_t count = 0;
  for (; count < met && hits[count].z <= horizon; ++count)
    horizon = std::min(horizon, parts_->model.horizon(hits[count]));
  hits.resize(count);
  return met;
}

std::size_t DiscVolumes::motion_ranges() const { return parts_->groups.size(); }

}  // namespace swept
