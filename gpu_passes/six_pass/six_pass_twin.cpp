#include "gpu_passes/six_pass/six_pass_twin.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "gpu_passes/six_pass/subframes.h"
#include "splat/kernel/kernel_integral.h"
#include "splat/kernel/ray_kernel.h"
#include "splat/kernel/screen_bounds.h"

namespace swept {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// The window, and the rays through its pixels.
struct View {
  int x, y, width, height;
  Projection projection;
  double near, delta;

  View(const KernelSet& set, const Scene& scene)
      : x(scene.film.crop_x),
        y(scene.film.crop_y),
        width(scene.film.window_width()),
        height(scene.film.window_height()),
        projection(set.projection),
        near(set.near),
        delta(scene.model.delta) {}

  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  }

  /// Calls visit(pixel index, tangent x, tangent y) wherever the kernel may cover a pixel.
  template <class Visit>
  void for_each_pixel(const MovingKernel& kernel, Visit visit) const {
    Octagon octagon;
    if (!screen_bounds(kernel, projection, near, octagon)) return;
    const PixelBox box = octagon.box();
    const auto cut = [](double position, int low, int high) {
      return static_cast<int>(std::clamp(position, double(low), double(high)));
    };
    const int x0 = cut(std::floor(box.x_min), x, x + width), x1 = cut(std::ceil(box.x_max), x, x + width);
    const int y0 = cut(std::floor(box.y_min), y, y + height), y1 = cut(std::ceil(box.y_max), y, y + height);
    for (int j = y0; j < y1; ++j)
      for (int i = x0; i < x1; ++i)
        visit(static_cast<std::size_t>(j - y) * static_cast<std::size_t>(width) + (i - x),
              (i + 0.5 - projection.center_x) / projection.focal_px,
              (j + 0.5 - projection.center_y) / projection.focal_px);
  }
};

/// Passes 1 and 2.
std::vector<double> depth_limits(const KernelSet& set, const View& view, double time) {
  std::vector<double> nearest(view.pixels(), infinity), limit(view.pixels(), infinity);
  for (const MovingKernel& kernel : set.kernels) {
    const KernelPlane<double> plane(kernel);
    view.for_each_pixel(kernel, [&](std::size_t pixel, double ray_x, double ray_y) {
      if (!plane.faces(ray_x, ray_y)) return;
      const RayCoordinates<double> at = plane.along(ray_x, ray_y);
      const double since = time - kernel.t_mid();
      const double u = at.u + at.du * since, v = at.v + at.dv * since, z = at.z + at.dz * since;
      if (!(u * u + v * v <= 1.0) || !(z >= view.near) || !(z < nearest[pixel])) return;
      nearest[pixel] = z;
      limit[pixel] = z + kernel.depth_tolerance;
    });
  }
  return limit;
}

}  // namespace

TwinTargets twin_passes(const KernelSet& set, const Scene& scene, GpuMethod method) {
  const View view(set, scene);
  const bool still = method == GpuMethod::still;
  TwinTargets targets;
  targets.limit_open = depth_limits(set, view, 0.0);
  targets.limit_close = still ? targets.limit_open : depth_limits(set, view, 1.0);
  targets.earliest.assign(view.pixels(), still ? 0.0 : 2.0);
  targets.latest.assign(view.pixels(), still ? 1.0 : -1.0);
  targets.color_sum.assign(4 * view.pixels(), 0.0);
  targets.behind_sum.assign(4 * view.pixels(), 0.0);
  targets.depth_sum.assign(2 * view.pixels(), 0.0);
  const bool hard = scene.model.coverage == Coverage::hard;
  for (const MovingKernel& kernel : set.kernels) {
    const KernelPlane<double> plane(kernel);
    view.for_each_pixel(kernel, [&](std::size_t pixel, double ray_x, double ray_y) {
      RayFragment<double> f;
      if (!plane.faces(ray_x, ray_y) ||
          !intersect_tube<double>(plane.along(ray_x, ray_y), kernel.t_begin, kernel.t_end, view.near,
                                  view.delta, kernel.weight, f))
        return;
      const double duration = f.t_end - f.t_begin;
      const double z_end = f.z_begin + f.z_rate * duration, z_min = std::min(f.z_begin, z_end);
      const bool visible = z_min <= targets.limit_open[pixel] || z_min <= targets.limit_close[pixel];
      if (!visible && hard) return;
      // Passes 3 and 4.
      if (visible && !still) {
        targets.earliest[pixel] = std::min(targets.earliest[pixel], f.t_begin);
        targets.latest[pixel] = std::max(targets.latest[pixel], f.t_end);
      }
      // Pass 5.
      const double y_end = f.y_begin + f.rate * duration;
      const double integral = f.peak * duration * mean_gaussian(f.y_begin, y_end);
      const double place = hard ? 0.0 : gaussian_centroid(f.y_begin, y_end);
      double* sum = (visible ? targets.color_sum : targets.behind_sum).data() + 4 * pixel;
      for (int c = 0; c < 3; ++c) sum[c] += integral * static_cast<double>(kernel.color[c]);
      sum[3] += integral;
      targets.depth_sum[2 * pixel + (visible ? 0 : 1)] += integral * std::lerp(f.z_begin, z_end, 0.5 + place);
    });
  }
  return targets;
}

namespace {

/// Pass 6, over all sub-frames.
class TwinFrame {
 public:
  explicit TwinFrame(const Scene& scene) : scene_(scene) {
    image_.x = scene.film.crop_x;
    image_.y = scene.film.crop_y;
    image_.width = scene.film.window_width();
    image_.height = scene.film.window_height();
    image_.film_width = scene.film.width;
    image_.film_height = scene.film.height;
    color_.assign(4 * image_.pixel_count(), 0.0);
    depth_.assign(image_.pixel_count(), 0.0);
    alpha_.assign(image_.pixel_count(), 0.0);
  }

  void add(const TwinTargets& targets, double share) {
    for (std::size_t p = 0; p < image_.pixel_count(); ++p) {
      const double covered = targets.latest[p] - targets.earliest[p], sum = targets.color_sum[4 * p + 3];
      const double edge = scene_.model.edge_weight;
      double alpha = 0.0;
      if (sum > 0.0 && covered > 0.0) {
        alpha = scene_.model.coverage == Coverage::hard ? covered : std::min(covered, sum / edge);
        add_surface(p, &targets.color_sum[4 * p], targets.depth_sum[2 * p], share * alpha);
        if (const double behind = targets.behind_sum[4 * p + 3]; behind > 0.0) {
          const double alpha_behind = (covered - alpha) * std::min(1.0, behind / (covered * edge));
          add_surface(p, &targets.behind_sum[4 * p], targets.depth_sum[2 * p + 1], share * alpha_behind);
          alpha += alpha_behind;
        }
      }
      for (int c = 0; c < 4; ++c)
        color_[4 * p + c] += share * (1.0 - alpha) * static_cast<double>(scene_.background[c]);
    }
  }

  Image finish() {
    for (const double value : color_) image_.rgba.push_back(static_cast<float>(value));
    for (std::size_t p = 0; p < image_.pixel_count(); ++p)
      image_.depth.push_back(static_cast<float>(alpha_[p] > 0.0 ? depth_[p] / alpha_[p] : infinity));
    return std::move(image_);
  }

 private:
  /// `sum`: Σ I w and Σ I.
  void add_surface(std::size_t p, const double* sum, double depth_sum, double alpha) {
    for (int c = 0; c < 4; ++c) color_[4 * p + c] += alpha * sum[c] / sum[3];
    depth_[p] += alpha * depth_sum / sum[3];
    alpha_[p] += alpha;
  }

  const Scene& scene_;
  Image image_;
  std::vector<double> color_, depth_, alpha_;
};

}  // namespace

Result<Rendered> render_six_pass_twin(const Scene& scene, const GpuRenderOptions& options) {
  if (Status status = options.validate(); !status) return status.error();
  if (Status status = scene.validate(); !status) return status.error();
  if (Status status = check_gpu_scene(scene); !status) return status.error();
  Subframes subframes(scene, options);
  TwinFrame frame(scene);
  for (int j = 0; j < subframes.count(); ++j)
    frame.add(twin_passes(subframes.kernels(j), scene, options.method), 1.0 / subframes.count());
  Rendered out;
  out.image = frame.finish();
  out.statistics.count("subframes", subframes.count());
  return out;
}

}  // namespace swept
