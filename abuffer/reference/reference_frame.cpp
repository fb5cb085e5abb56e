#include "abuffer/reference/reference_frame.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>
#include <utility>

#include <tbb/blocked_range.h>
#include <Eigen/Geometry>

#include "abuffer/parallel.h"
#include "abuffer/reference/mesh_reference.h"

namespace swept::reference {
namespace {

constexpr int band_height = 16;  // px; few enough bands to bin quickly, enough of them to share out

/// Whether a kernel exists at `tau`. Segments are half open, so that of two that meet only one is seen.
bool exists_at(const MovingKernel& kernel, double tau) {
  return tau >= kernel.t_begin && (tau < kernel.t_end || (kernel.t_end >= 1.0f && tau <= 1.0));
}

/// The pixels of [begin, end) whose centres may lie in [lowest, highest]. One pixel more on either side
/// swallows rounding; clamping comes before the conversion, for a disc may project a long way off the film.
std::pair<int, int> pixel_span(double lowest, double highest, int begin, int end) {
  const double first = std::ceil(lowest - 0.5) - 1.0;
  const double last = std::floor(highest - 0.5) + 1.0;
  return {static_cast<int>(std::clamp<double>(first, begin, end)),
          static_cast<int>(std::clamp<double>(last + 1.0, begin, end))};
}

/// The disc's axis-aligned box in space, cut off at the near plane and projected. In front of that plane
/// x/z is monotonic in both x and z, so that the corners bound it.
PixelBox bounding_box(const Eigen::Vector3d& center, const Eigen::Vector3d& axis_u,
                      const Eigen::Vector3d& axis_v, const Projection& projection, double near,
                      const PixelBox& window) {
  const Eigen::Vector3d half = (axis_u.array().square() + axis_v.array().square()).sqrt();
  const Eigen::Vector3d low = center - half, high = center + half;
  if (high.z() < near) return {};
  const double nearest = std::max(low.z(), near), farthest = high.z();
  const auto tangent_low = [&](int axis) {
    return projection.orthographic ? low[axis] : std::min(low[axis] / nearest, low[axis] / farthest);
  };
  const auto tangent_high = [&](int axis) {
    return projection.orthographic ? high[axis] : std::max(high[axis] / nearest, high[axis] / farthest);
  };
  const auto [x_begin, x_end] =
      pixel_span(projection.center_x + projection.focal_px * tangent_low(0),
                 projection.center_x + projection.focal_px * tangent_high(0), window.x_begin, window.x_end);
  const auto [y_begin, y_end] =
      pixel_span(projection.center_y + projection.focal_px * tangent_low(1),
                 projection.center_y + projection.focal_px * tangent_high(1), window.y_begin, window.y_end);
  return {x_begin, y_begin, x_end, y_end};
}

/// Nearest first; of equally near fragments those that show their front, then those whose side is not known.
/// What follows only makes the order total on content: of those the most tolerant leads, so that a surface is
/// all that is within the tolerance of any of its nearest.
bool before(const Fragment& a, const Fragment& b) {
  const auto key = [](const Fragment& f) {
    const Eigen::Vector4d& c = f.disc->color;
    return std::make_tuple(f.depth, -f.side, -f.disc->tolerance, -f.weight, c[0], c[1], c[2], c[3]);
  };
  return key(a) < key(b);
}

/// Puts the fragments that form a surface with the first one at the front, all else behind them in its order.
std::span<const Fragment> front_surface(std::span<Fragment> fragments) {
  const Fragment nearest = fragments.front();
  const double limit = nearest.depth + nearest.disc->tolerance;
  const auto belongs = [&](const Fragment& f) { return f.depth <= limit && f.side * nearest.side >= 0; };
  const auto rest = std::stable_partition(fragments.begin(), fragments.end(), belongs);
  return {fragments.begin(), rest};
}

Surface blend(std::span<const Fragment> fragments, const ImageModel& model) {
  Eigen::Vector4d color = Eigen::Vector4d::Zero();
  double depth = 0.0, weight = 0.0;
  for (const Fragment& fragment : fragments) {
    color += fragment.weight * fragment.disc->color;
    depth += fragment.weight * fragment.depth;
    weight += fragment.weight;
  }
  const double coverage = model.coverage == Coverage::hard ? 1.0 : std::min(1.0, weight / model.edge_weight);
  return {color / weight, depth / weight, coverage};
}

}  // namespace

Ray ray_at(const Projection& projection, double film_x, double film_y) {
  const Eigen::Vector2d on_film((film_x - projection.center_x) / projection.focal_px,
                                (film_y - projection.center_y) / projection.focal_px);
  if (projection.orthographic) return {{on_film.x(), on_film.y(), 0.0}, Eigen::Vector3d::UnitZ()};
  return {Eigen::Vector3d::Zero(), {on_film.x(), on_film.y(), 1.0}};
}

Disc place(const MovingKernel& kernel, double tau, const Projection& projection, double near,
           const PixelBox& window) {
  const Eigen::Vector3d axis_u = kernel.axis_u.cast<double>(), axis_v = kernel.axis_v.cast<double>();
  Disc disc;
  disc.normal = axis_u.cross(axis_v);
  const double normal_squared = disc.normal.squaredNorm();
  if (!exists_at(kernel, tau) || !(kernel.weight > 0.0f) || !(normal_squared > 0.0)) return disc;
  disc.center = kernel.center + (tau - kernel.t_mid()) * kernel.velocity;
  disc.dual_u = axis_v.cross(disc.normal) / normal_squared;
  disc.dual_v = disc.normal.cross(axis_u) / normal_squared;
  disc.facing = kernel.facing.cast<double>();
  disc.outside = kernel.outside.cast<double>();
  disc.plane = disc.normal.dot(disc.center);
  disc.weight = kernel.weight;
  disc.tolerance =
      std::max(0.0, kernel.depth_tolerance + (tau - kernel.t_mid()) * double{kernel.tolerance_rate});
  disc.color = kernel.color.cast<double>() + (tau - kernel.t_mid()) * kernel.color_rate.cast<double>();
  disc.box = bounding_box(disc.center, axis_u, axis_v, projection, near, window);
  return disc;
}

std::optional<Fragment> meet(const Disc& disc, const Ray& ray, double near, double delta) {
  if (!disc.facing.isZero(0.0) && !(disc.facing.dot(ray.direction) < 0.0)) return std::nullopt;
  const double slope = disc.normal.dot(ray.direction);
  if (slope == 0.0) return std::nullopt;
  const double depth = (disc.plane - disc.normal.dot(ray.from)) / slope;
  if (!(depth >= near)) return std::nullopt;
  const Eigen::Vector3d from_center = ray.from + depth * ray.direction - disc.center;
  const double u = disc.dual_u.dot(from_center), v = disc.dual_v.dot(from_center);
  const double radius_squared = u * u + v * v;
  if (!(radius_squared <= 1.0)) return std::nullopt;
  const int side = disc.outside.isZero(0.0) ? 0 : disc.outside.dot(ray.direction) < 0.0 ? 1 : -1;
  return Fragment{depth, disc.weight * std::exp(-delta * radius_squared), &disc, side};
}

void find_surfaces(std::span<Fragment> fragments, const ImageModel& model, std::span<Surface> others,
                   std::vector<Surface>& seen) {
  std::sort(fragments.begin(), fragments.end(), before);
  std::vector<Surface> of_discs;
  for (std::span<Fragment> rest = fragments; !rest.empty();) {
    const std::span<const Fragment> front = front_surface(rest);
    of_discs.push_back(blend(front, model));
    rest = rest.subspan(front.size());
  }
  const auto nearer = [](const Surface& a, const Surface& b) { return a.depth < b.depth; };
  std::stable_sort(others.begin(), others.end(), nearer);
  std::merge(of_discs.begin(), of_discs.end(), others.begin(), others.end(), std::back_inserter(seen),
             nearer);
}

std::size_t shade(std::span<Fragment> fragments, const ImageModel& model, const Eigen::Vector4d& background,
                  PixelSum& sum, std::span<Surface> others) {
  std::vector<Surface> seen;
  find_surfaces(fragments, model, others, seen);
  double transmittance = 1.0;
  std::size_t surfaces = 0;
  for (const Surface& surface : seen) {
    if (!(transmittance > 0.0)) break;
    const double alpha = surface.coverage * surface.color.w();
    sum.color += transmittance * surface.coverage * surface.color;
    sum.alpha += transmittance * alpha;
    sum.alpha_depth += transmittance * alpha * surface.depth;
    transmittance *= 1.0 - alpha;
    ++surfaces;
  }
  if (transmittance > 0.0) sum.color += transmittance * background;
  return surfaces;
}

FrameSum::FrameSum(const Film& film, const ImageModel& model, const Eigen::Vector4f& background)
    : film_(film),
      model_(model),
      background_(background.cast<double>()),
      window_{film.crop_x, film.crop_y, film.crop_x + film.window_width(),
              film.crop_y + film.window_height()},
      sums_(static_cast<std::size_t>(film.window_width()) * static_cast<std::size_t>(film.window_height())) {}

void FrameSum::add(const KernelSet& set, double tau, std::span<const MeshAt> meshes) {
  place_all(set, tau);
  bin_by_band();
  std::vector<Counts> counts(band_count());
  parallel_for_each_index(counts.size(),
                          [&](std::size_t band) { counts[band] = render_band(set, meshes, band); });
  for (const Counts& count : counts) {
    fragments_ += count.fragments;
    surfaces_ += count.surfaces;
  }
  ++instants_;
}

Image FrameSum::mean() const {
  Image image{window_.x_begin,
              window_.y_begin,
              film_.window_width(),
              film_.window_height(),
              film_.width,
              film_.height,
              {},
              {}};
  image.rgba.reserve(4 * sums_.size());
  image.depth.reserve(sums_.size());
  for (const PixelSum& sum : sums_) {
    for (const double channel : sum.color) {
      image.rgba.push_back(static_cast<float>(channel / static_cast<double>(instants_)));
    }
    image.depth.push_back(sum.alpha > 0.0 ? static_cast<float>(sum.alpha_depth / sum.alpha)
                                          : std::numeric_limits<float>::infinity());
  }
  return image;
}

void FrameSum::place_all(const KernelSet& set, double tau) {
  discs_.resize(set.kernels.size());
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, discs_.size()), [&](const auto& range) {
    for (std::size_t k = range.begin(); k != range.end(); ++k) {
      discs_[k] = place(set.kernels[k], tau, set.projection, set.near, window_);
    }
  });
}

void FrameSum::bin_by_band() {
  band_begin_.assign(band_count() + 1, 0);
  const auto for_each_entry = [this](auto&& visit) {
    for (std::size_t k = 0; k < discs_.size(); ++k) {
      const PixelBox& box = discs_[k].box;
      if (box.empty()) continue;
      for (std::size_t band = band_of(box.y_begin); band <= band_of(box.y_end - 1); ++band) visit(band, k);
    }
  };
  for_each_entry([this](std::size_t band, std::size_t) { ++band_begin_[band + 1]; });
  for (std::size_t band = 0; band < band_count(); ++band) band_begin_[band + 1] += band_begin_[band];
  band_discs_.resize(band_begin_.back());
  std::vector<std::size_t> next(band_begin_.begin(), band_begin_.end() - 1);
  for_each_entry(
      [&](std::size_t band, std::size_t k) { band_discs_[next[band]++] = static_cast<std::uint32_t>(k); });
}

FrameSum::Counts FrameSum::render_band(const KernelSet& set, std::span<const MeshAt> meshes,
                                       std::size_t band) {
  const std::span<const std::uint32_t> candidates =
      std::span(band_discs_).subspan(band_begin_[band], band_begin_[band + 1] - band_begin_[band]);
  const int width = film_.window_width();
  const int y_begin = window_.y_begin + static_cast<int>(band) * band_height;
  const int y_end = std::min(y_begin + band_height, window_.y_end);
  std::vector<std::vector<Fragment>> row(static_cast<std::size_t>(width));  // fragments of each pixel
  std::vector<Surface> others;
  Counts counts;
  for (int y = y_begin; y < y_end; ++y) {
    for (auto& pixel : row) pixel.clear();
    for (const std::uint32_t k : candidates) {
      const Disc& disc = discs_[k];
      if (y < disc.box.y_begin || y >= disc.box.y_end) continue;
      for (int x = disc.box.x_begin; x < disc.box.x_end; ++x) {
        const auto fragment = meet(disc, ray_through(set.projection, x, y), set.near, model_.delta);
        if (fragment) row[static_cast<std::size_t>(x - window_.x_begin)].push_back(*fragment);
      }
    }
    PixelSum* const sums = &sums_[static_cast<std::size_t>(y - window_.y_begin) * row.size()];
    for (std::size_t x = 0; x < row.size(); ++x) {
      counts.fragments += row[x].size();
      others.clear();
      for (const MeshAt& mesh : meshes) mesh.meet(window_.x_begin + static_cast<int>(x), y, others);
      counts.surfaces += shade(row[x], model_, background_, sums[x], others);
    }
  }
  return counts;
}

std::size_t FrameSum::band_of(int y) const {
  return static_cast<std::size_t>((y - window_.y_begin) / band_height);
}

std::size_t FrameSum::band_count() const { return band_of(window_.y_end - 1) + 1; }

}  // namespace swept::reference
