#include "abuffer/reference/reference.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "abuffer/reference/mesh_reference.h"
#include "abuffer/reference/posed_scene.h"
#include "abuffer/reference/reference_frame.h"
#include "abuffer/reference/splat_reference.h"
#include "abuffer/render_valid.h"
#include "splat/lens_points.h"
#include "splat/motion/instant.h"
#include "splat/motion/segments.h"
#include "splat/stopwatch.h"
#include "splat/without_throwing.h"

namespace swept {
namespace {

/// The kernels that exist at a shutter time, through that point of the lens. The set lives until the next
/// call.
using KernelsAt = std::function<const KernelSet&(double tau, const Eigen::Vector2d& lens_point)>;

struct Source {
  KernelsAt kernels_at;
  bool still = false;
  const char* motion = "";
  std::vector<Eigen::Vector2d> lens = {Eigen::Vector2d::Zero()};  ///< the points it is looked through
};

/// Triangles are on their true path at every instant.
std::vector<reference::MeshAt> meshes_at(const Scene& scene, double tau) {
  std::vector<reference::MeshAt> meshes;
  for (const Object& object : scene.objects)
    if (!object.triangles.empty()) meshes.emplace_back(scene, object, scene.exposure().at(tau));
  return meshes;
}

bool has_meshes(const Scene& scene) {
  return std::any_of(scene.objects.begin(), scene.objects.end(),
                     [](const Object& object) { return !object.triangles.empty(); });
}

/// Says how many still images of all are done.
class Progress {
 public:
  Progress(const RenderControl& control, int images) : control_(control), images_(images) {}

  /// False if the render is to stop.
  bool one_more() {
    if (control_.progress) call_back(control_.progress, static_cast<double>(++done_) / images_);
    return !control_.stop.stop_requested();
  }

 private:
  const RenderControl& control_;
  int images_, done_ = 0;
};

/// Adds the still images at the midpoints of `samples` strata of the shutter. False: stopped on the way.
bool expose(const Scene& scene, const Source& source, int samples, Progress& progress,
            reference::FrameSum& sum) {
  // Only meshes through a lens need a scene with another eye.
  std::optional<Scene> moved;
  if (scene.camera.aperture.radius > 0.0 && has_meshes(scene)) {
    moved = scene;
    moved->camera.aperture = {};
  }
  for (const Eigen::Vector2d& point : source.lens) {
    if (moved) moved->camera.lens_point = point;
    for (int i = 0; i < samples; ++i) {
      const double tau = (i + 0.5) / samples;
      sum.add(source.kernels_at(tau, point), tau, meshes_at(moved ? *moved : scene, tau));
      if (!progress.one_more()) return false;
    }
  }
  return true;
}

bool nothing_moves(const KernelSet& set) {
  return std::all_of(set.kernels.begin(), set.kernels.end(), [](const MovingKernel& kernel) {
    return kernel.still() && !kernel.changes_color() && kernel.t_begin <= 0.0f && kernel.t_end >= 1.0f;
  });
}

bool meshes_stand_still(const Scene& scene) {
  const Exposure exposure = scene.exposure();
  return std::all_of(scene.objects.begin(), scene.objects.end(), [&](const Object& object) {
    return object.triangles.empty() || stands_still(scene, object, exposure);
  });
}

double rmse_of_rgb(const Image& a, const Image& b) {
  double squares = 0.0;
  for (std::size_t i = 0; i < a.rgba.size(); ++i) {
    if (i % 4 == 3) continue;
    const double difference = static_cast<double>(a.rgba[i]) - static_cast<double>(b.rgba[i]);
    squares += difference * difference;
  }
  return std::sqrt(squares / (3.0 * static_cast<double>(a.pixel_count())));
}

void add_kernel_counts(const KernelSet& set, Statistics& statistics) {
  statistics.count("surfels", static_cast<double>(set.surfels));
  statistics.count("kernels", static_cast<double>(set.kernels.size()));
  statistics.count("still_kernels", static_cast<double>(set.still_kernels));
  statistics.count("culled_degenerate", static_cast<double>(set.culled_degenerate));
  statistics.count("culled_near", static_cast<double>(set.culled_near));
}

Result<Rendered> render(const Source& source, const Scene& scene, const ReferenceOptions& options,
                        const RenderControl& control) {
  Rendered rendered;
  Statistics& statistics = rendered.statistics;
  const int samples = source.still ? 1 : options.samples;

  Stopwatch watch;
  reference::FrameSum sum(scene.film, scene.model, scene.background);
  Progress progress(control,
                    static_cast<int>(source.lens.size()) * (source.still ? 1 : samples + samples / 2));
  if (!expose(scene, source, samples, progress, sum)) return stopped_error();
  rendered.image = sum.mean();
  statistics.time("still images", watch.lap());

  std::uint64_t instants = sum.instants(), fragments = sum.fragments(), surfaces = sum.surfaces();
  double error = 0.0;
  if (!source.still) {
    reference::FrameSum half(scene.film, scene.model, scene.background);
    if (!expose(scene, source, samples / 2, progress, half)) return stopped_error();
    error = rmse_of_rgb(rendered.image, half.mean()) / std::sqrt(6.0);
    instants += half.instants(), fragments += half.fragments(), surfaces += half.surfaces();
    statistics.time("error estimate", watch.lap());
  }

  statistics.count("samples", samples);
  statistics.count("instants", static_cast<double>(instants));
  statistics.count("fragments", static_cast<double>(fragments));
  statistics.count("surfaces", static_cast<double>(surfaces));
  statistics.count("reference_error_rmse", error);
  statistics.count("reference_error_psnr_db", -20.0 * std::log10(error));
  statistics.effect(source.still
                        ? "motion blur: skipped, for the shutter is closed or nothing moves"
                        : "motion blur: " + std::to_string(samples) + " still images of " + source.motion);
  return rendered;
}

/// Row by row, each exposed at its own time.
template <class Rebuild>
Result<Rendered> render_rows(const Rebuild& rebuild, const Exposure& exposure, const Scene& scene,
                             const ReferenceOptions& options, const RenderControl& control) {
  Rendered whole;
  whole.image = blank_image(scene.film);
  const Image& window = whole.image;
  double squares = 0.0;
  for (int y = window.y; y < window.y + window.height; ++y) {
    const Exposure of_row = exposure.of_row(y);
    Scene row;
    row.film = scene.film;
    row.film.crop_x = window.x;
    row.film.crop_y = y;
    row.film.crop_width = window.width;
    row.film.crop_height = 1;
    row.model = scene.model;
    row.background = scene.background;
    RenderControl quiet = control;
    quiet.progress = {};
    Result<Rendered> rendered = render({[&](double tau, const Eigen::Vector2d& point) -> const KernelSet& {
                                          return rebuild(tau, point, of_row);
                                        },
                                        of_row.instant(),
                                        "the true path, row by row",
                                        {Eigen::Vector2d::Zero()}},
                                       row, options, quiet);
    if (!rendered) return rendered;
    const auto width = static_cast<std::size_t>(window.width),
               first = static_cast<std::size_t>(y - window.y) * width;
    std::copy(rendered->image.rgba.begin(), rendered->image.rgba.end(),
              whole.image.rgba.begin() + static_cast<std::ptrdiff_t>(4 * first));
    std::copy(rendered->image.depth.begin(), rendered->image.depth.end(),
              whole.image.depth.begin() + static_cast<std::ptrdiff_t>(first));
    const double error = rendered->statistics.counter("reference_error_rmse").value_or(0.0);
    squares += error * error;
    if (control.progress) call_back(control.progress, static_cast<double>(y + 1 - window.y) / window.height);
  }
  const double error = std::sqrt(squares / window.height);
  whole.statistics.count("samples", options.samples);
  whole.statistics.effect("motion blur: " + std::to_string(options.samples) +
                          " still images of the true path for each row");
  whole.statistics.count("reference_error_rmse", error);
  whole.statistics.count("reference_error_psnr_db", -20.0 * std::log10(error));
  return whole;
}

Result<Rendered> render_segments(const KernelSet& kernels, const Scene& scene,
                                 const ReferenceOptions& options, const RenderControl& control) {
  if (Status status = refuse_lens(scene, "a picture of given kernels"); !status) return status.error();
  const auto same_for_all = [&](double, const Eigen::Vector2d&) -> const KernelSet& { return kernels; };
  const bool still = nothing_moves(kernels) && meshes_stand_still(scene);
  Result<Rendered> rendered =
      render({same_for_all, still, "linear segments", {Eigen::Vector2d::Zero()}}, scene, options, control);
  if (rendered) add_kernel_counts(kernels, rendered->statistics);
  return rendered;
}

/// Along the true path, or through a lens along segments.
Result<Rendered> render_built(const Scene& scene, const ReferenceOptions& options,
                              const RenderControl& control) {
  const Exposure exposure = scene.exposure();
  const bool smooth = options.motion == ReferenceMotion::smooth;
  // Only a lens needs another eye, and then a scene of its own.
  std::optional<Scene> moved;
  if (scene.camera.aperture.radius > 0.0) {
    moved = scene;
    moved->camera.aperture = {};
  }
  KernelSet kernels;
  double seconds = 0.0;
  std::optional<reference::PosedScene> posed;
  const bool own_paths = smooth && reference::has_own_paths(scene);
  if (own_paths && !moved) posed.emplace(scene);
  const auto rebuild = [&](double tau, const Eigen::Vector2d& point,
                           const Exposure& exposed) -> const KernelSet& {
    const bool same_eye = !moved || (moved->camera.lens_point == point && kernels.surfels > 0);
    if (!smooth && same_eye && kernels.surfels > 0) return kernels;
    Stopwatch watch;
    if (moved) moved->camera.lens_point = point;
    if (own_paths && !same_eye) posed.emplace(*moved);
    const Scene& seen = moved ? *moved : scene;
    const double frame = exposed.at(tau);
    kernels = !smooth ? build_kernels(seen, seen.exposure(), control.stop)
                      : build_kernels(posed ? posed->at(frame) : seen, {frame, frame}, control.stop);
    throw_if_stopped(control.stop);
    seconds += watch.lap();
    return kernels;
  };
  const bool still = nothing_moves(scene, exposure);
  if (!still && exposure.row_delay != 0.0)
    if (Status status = refuse_triangles(scene, "the reference row by row"); !status) return status.error();
  Result<Rendered> rendered =
      still || exposure.row_delay == 0.0
          ? render({[&](double tau, const Eigen::Vector2d& point) -> const KernelSet& {
                      return rebuild(tau, point, exposure);
                    },
                    still, smooth ? "the true path" : "linear segments",
                    lens_points(scene.camera.aperture, lens_point_count(scene))},
                   scene, options, control)
          : render_rows(rebuild, exposure, scene, options, control);
  if (!rendered) return rendered;
  add_kernel_counts(kernels, rendered->statistics);
  rendered->statistics.time("kernels", seconds);
  if (moved) rendered->statistics.count("lens_points", lens_point_count(scene));
  return rendered;
}

}  // namespace

Status ReferenceOptions::validate() const {
  if (samples < 2 || samples > (1 << 20) || samples % 2 != 0) {
    return Error{"", "samples", "must be even and from 2 to 1048576, not " + std::to_string(samples)};
  }
  return Done{};
}

Result<Rendered> render_reference(const KernelSet& kernels, const Scene& scene,
                                  const ReferenceOptions& options, const RenderControl& control) {
  if (scene.film.has_overscan())
    return Error{"", "/film/overscan", "is no part of the picture that given kernels are of",
                 ErrorKind::unsupported};
  return render_valid(scene, options, control,
                      [&](const auto&...) { return render_segments(kernels, scene, options, control); });
}

Result<Rendered> render_reference(const Scene& scene, const ReferenceOptions& options,
                                  const RenderControl& control) {
  const bool splats = std::any_of(scene.objects.begin(), scene.objects.end(),
                                  [](const Object& object) { return object.splats.size() > 0; });
  if (splats) {
    if (Status status = control.validate(); !status) return status.error();
    return without_throwing("to render the frame", [&]() -> Result<Rendered> {
      return render_overscan(scene, [&](const Scene& on_film) {
        return render_splat_reference(on_film, {options.samples, control.threads}, control);
      });
    });
  }
  return render_valid(scene, options, control, [&](const Scene& on_film, const auto&...) -> Result<Rendered> {
    if (on_film.camera.aperture.radius > 0.0) {
      if (Status status = refuse_row_delay(on_film, "a lens"); !status) return status.error();
    }
    const auto fit = [&](std::size_t kernels) {
      return check_bytes(kernels * sizeof(MovingKernel), control, "the kernels");
    };
    // One each at an instant, and more over the exposure.
    std::size_t discs = 0;
    for (const Object& object : on_film.objects) discs += object.discs();
    if (Status fits = fit(discs); !fits) return fits.error();
    if (options.motion == ReferenceMotion::smooth || on_film.camera.aperture.radius > 0.0)
      return render_built(on_film, options, control);
    if (Status status = refuse_row_delay(on_film, "the reference along segments"); !status)
      return status.error();
    Stopwatch watch;
    const KernelSet kernels = build_kernels(on_film, on_film.exposure(), control.stop);
    throw_if_stopped(control.stop);
    if (Status fits = fit(kernels.kernels.size()); !fits) return fits.error();
    const double seconds = watch.lap();
    Result<Rendered> rendered = render_segments(kernels, on_film, options, control);
    if (rendered) rendered->statistics.time("kernels", seconds);
    return rendered;
  });
}

}  // namespace swept
