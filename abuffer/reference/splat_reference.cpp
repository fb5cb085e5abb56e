#include "abuffer/reference/splat_reference.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "abuffer/parallel.h"
#include "abuffer/progress_of.h"
#include "abuffer/reference/splat_formulas.h"
#include "abuffer/reference/surfaces_at.h"
#include "abuffer/render_valid.h"
#include "splat/lens_points.h"

namespace swept {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using reference::decoded;
using reference::encoded;

/// Rows of pixels that a thread takes at once.
constexpr int band_rows = 8;

/// A splat as one instant sees it.
struct Seen {
  double depth = 0.0, opacity = 0.0;
  Vector3d color;
  Vector2d center;       ///< px
  Matrix2d from_offset;  ///< inverse covariance, 1/px²: r² = dᵀ·M·d
  bool flat = false;
  Vector3d at, normal, dual_u, dual_v;  ///< of a disc, camera space
  int x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;
};

/// Where rays of the film go at one instant.
struct View {
  CameraInstant camera;
  double focal_x, focal_y, center_x, center_y;  ///< px

  View(const Scene& scene, double frame) : camera(scene.camera.at(frame)) {
    const Projection p = projection_of(scene.film, camera);
    focal_x = p.focal_px * camera.lens.stretch_x, focal_y = p.focal_px;
    center_x = p.center_x, center_y = p.center_y;
  }
};

struct Pixel {
  Vector3d color = Vector3d::Zero();
  double light = 1.0;  ///< transmittance
  double depth = 0.0;  ///< weighted by what each adds to alpha
  bool done = false;
};

/// What instants add up to.
struct PixelSum {
  Vector3d color = Vector3d::Zero();  ///< linear, the background included
  double alpha = 0.0, depth = 0.0;    ///< without the background
};

bool blends_linearly(const Scene& scene, const Object& object) {
  if (scene.splats.blending != SplatBlending::file) return scene.splats.blending == SplatBlending::linear;
  return object.splats.colors == SplatColors::linear;
}

/// Adds still images up.
class Frame {
 public:
  /// add() throws Stopped after `stop`.
  Frame(const Scene& scene, std::stop_token stop)
      : scene_(scene),
        model_(scene.splats),
        image_(blank_image(scene.film)),
        stop_(std::move(stop)),
        surfaces_(scene) {
    sums_.resize(image_.pixel_count());
    for (const Object& object : scene.objects)
      if (object.splats.size() > 0) linear_ = blends_linearly(scene, object);
  }

  void add(double frame) {
    const View view(scene_, frame);
    seen_.clear();
    for (const Object& object : scene_.objects) see(object, view, frame);
    std::stable_sort(seen_.begin(), seen_.end(),
                     [](const Seen& a, const Seen& b) { return a.depth < b.depth; });
    surfaces_.move_to(frame);
    const auto bands = static_cast<std::size_t>((image_.height + band_rows - 1) / band_rows);
    std::vector<std::uint64_t> fragments(bands);
    parallel_for_each_index(bands, [&](std::size_t band) {
      throw_if_stopped(stop_);
      const int y = image_.y + static_cast<int>(band) * band_rows;
      fragments[band] = surfaces_.any() ? draw_among_surfaces(view, y) : draw(view, y);
    });
    fragments_ = std::accumulate(fragments.begin(), fragments.end(), fragments_);
    ++instants_;
  }

  [[nodiscard]] Image mean() const {
    Image image = image_;
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const PixelSum& sum = sums_[i];
      const double alpha = sum.alpha / instants_;
      for (int c = 0; c < 3; ++c)
        image.rgba[4 * i + static_cast<std::size_t>(c)] = static_cast<float>(sum.color[c] / instants_);
      image.rgba[4 * i + 3] = static_cast<float>(alpha + (1.0 - alpha) * double{scene_.background[3]});
      image.depth[i] = sum.alpha > 0.0 ? static_cast<float>(sum.depth / sum.alpha)
                                       : std::numeric_limits<float>::infinity();
    }
    return image;
  }

  [[nodiscard]] std::uint64_t fragments() const { return fragments_; }

 private:
  void see(const Object& object, const View& view, double frame);
  [[nodiscard]] bool project(const Matrix3d& axes, const SplatCloud& cloud, const View& view,
                             Seen& seen) const;
  [[nodiscard]] bool place_disc(const Matrix3d& axes, const View& view, Seen& seen) const;
  void bound(Seen& seen, const Vector2d& reach) const;
  [[nodiscard]] double distance_squared(const Seen& seen, const View& view, int x, int y) const;
  [[nodiscard]] std::uint64_t draw(const View& view, int y_begin);
  [[nodiscard]] std::uint64_t draw_among_surfaces(const View& view, int y_begin);
  [[nodiscard]] double alpha_at(const Seen& seen, const View& view, int x, int y) const;
  [[nodiscard]] bool blend(const Seen& seen, double alpha, Pixel& pixel) const;
  void finish(const Pixel& pixel, PixelSum& sum) const;
  [[nodiscard]] double covered(double color, double light, double behind) const;

  const Scene& scene_;
  const SplatModel& model_;
  Image image_;
  std::stop_token stop_;
  std::vector<PixelSum> sums_;
  std::vector<Seen> seen_;
  reference::SurfacesAt surfaces_;
  bool linear_ = false;
  double instants_ = 0.0;
  std::uint64_t fragments_ = 0;
};

void Frame::see(const Object& object, const View& view, double frame) {
  const SplatCloud& cloud = object.splats;
  const Eigen::Affine3d world_from_object = object.transform.at(frame);
  // Colours turn with the object, and are mirrored with it; they are not stretched.
  Matrix3d turn = world_from_object.linear();
  for (int i = 0; i < 3; ++i)
    if (turn.col(i).norm() > 0.0) turn.col(i).normalize();
  const Matrix3d camera_from_object = view.camera.camera_from_world.linear() * world_from_object.linear();
  const auto coefficients = static_cast<std::size_t>(SplatCloud::coefficients(cloud.degree));
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (i % 1024 == 0) throw_if_stopped(stop_);
    Vector3d position = cloud.position[i];
    if (!cloud.velocity.empty()) position += cloud.velocity[i].cast<double>() * (frame - cloud.frame);
    Eigen::Quaterniond rotation = cloud.rotation[i].cast<double>();
    double opacity = double{cloud.opacity[i]};
    if (cloud.motion) reference::move_by_itself(cloud, i, frame, position, rotation, opacity);
    const Vector3d from_eye = world_from_object * position - view.camera.eye;
    Seen seen;
    seen.at = view.camera.camera_from_world.linear() * from_eye;
    seen.depth = seen.at.z();
    seen.opacity = opacity;
    if (!(seen.depth > model_.near)) continue;
    const Matrix3d axes =
        camera_from_object * rotation.toRotationMatrix() * cloud.scale[i].cast<double>().asDiagonal();
    const double divisor = view.camera.orthographic ? 1.0 : seen.depth;
    seen.center = {view.center_x + view.focal_x * seen.at.x() / divisor,
                   view.center_y + view.focal_y * seen.at.y() / divisor};
    if (!(cloud.flat ? place_disc(axes, view, seen) : project(axes, cloud, view, seen))) continue;
    // All rays of an orthographic camera run one way.
    const Vector3d looking =
        view.camera.orthographic ? Vector3d(view.camera.camera_from_world.linear().row(2)) : from_eye;
    const std::array<double, 16> basis =
        reference::harmonics_towards((turn.transpose() * looking).stableNormalized());
    const float* harmonics = cloud.harmonics.data() + 3 * coefficients * i;
    for (int c = 0; c < 3; ++c) {
      double value = 0.5;
      for (std::size_t k = 0; k < coefficients; ++k)
        value += basis[k] * double{harmonics[3 * k + static_cast<std::size_t>(c)]};
      seen.color[c] = std::max(0.0, value);
    }
    seen_.push_back(seen);
  }
}

/// Kerbl et al., section 4: Σ' = J W Σ Wᵀ Jᵀ, and what the film adds to it.
bool Frame::project(const Matrix3d& axes, const SplatCloud& cloud, const View& view, Seen& seen) const {
  // x/z and y/z in J are held to 0.3 of half the film beyond its edge, as in the implementations.
  constexpr double beyond = 0.3;
  const auto held = [&](double tangent, double center, double size, double focal) {
    const double margin = beyond * 0.5 * size / focal;
    return std::clamp(tangent, -center / focal - margin, (size - center) / focal + margin);
  };
  const double z = seen.depth;
  const double x = held(seen.at.x() / z, view.center_x, image_.film_width, view.focal_x);
  const double y = held(seen.at.y() / z, view.center_y, image_.film_height, view.focal_y);
  Eigen::Matrix<double, 2, 3> jacobian;
  jacobian << view.focal_x / z, 0.0, -view.focal_x * x / z, 0.0, view.focal_y / z, -view.focal_y * y / z;
  if (view.camera.orthographic) jacobian << view.focal_x, 0.0, 0.0, 0.0, view.focal_y, 0.0;
  const Eigen::Matrix<double, 2, 3> on_film = jacobian * axes;
  const Matrix2d before = on_film * on_film.transpose();
  const Matrix2d covariance = before + model_.dilation_px2 * Matrix2d::Identity();
  const double determinant = covariance.determinant();
  if (!(determinant > 0.0) || !covariance.allFinite()) return false;
  if (cloud.filter == SplatFilter::antialiased)
    seen.opacity *= std::sqrt(std::max(0.0, before.determinant() / determinant));
  seen.from_offset = covariance.inverse();
  bound(seen, covariance.diagonal().cwiseSqrt());
  return true;
}

/// Huang et al., section 4: a ray meets the disc's plane.
bool Frame::place_disc(const Matrix3d& axes, const View&, Seen& seen) const {
  seen.flat = true;
  const Vector3d u = axes.col(0), v = axes.col(1), normal = u.cross(v);
  const double square = normal.squaredNorm();
  seen.normal.setZero();
  if (square > 0.0) {
    seen.normal = normal;
    seen.dual_u = v.cross(normal) / square;
    seen.dual_v = normal.cross(u) / square;
  }
  seen.x_begin = image_.x, seen.x_end = image_.x + image_.width;
  seen.y_begin = image_.y, seen.y_end = image_.y + image_.height;
  return true;
}

/// `reach` is one standard deviation of each coordinate.
void Frame::bound(Seen& seen, const Vector2d& reach) const {
  const double over = seen.opacity / model_.least_alpha;
  if (!(over >= 1.0)) return;
  const Vector2d half = std::sqrt(2.0 * std::log(over)) * reach;
  const auto whole = [](double value, int low, int high) {
    return static_cast<int>(std::clamp(value, double{1.0} * low, double{1.0} * high));
  };
  const int right = image_.x + image_.width, bottom = image_.y + image_.height;
  seen.x_begin = whole(std::floor(seen.center.x() - half.x() - 1.0), image_.x, right);
  seen.x_end = whole(std::ceil(seen.center.x() + half.x() + 1.0), image_.x, right);
  seen.y_begin = whole(std::floor(seen.center.y() - half.y() - 1.0), image_.y, bottom);
  seen.y_end = whole(std::ceil(seen.center.y() + half.y() + 1.0), image_.y, bottom);
}

/// In standard deviations, from the centre of pixel (x, y).
double Frame::distance_squared(const Seen& seen, const View& view, int x, int y) const {
  const Vector2d pixel(x + 0.5, y + 0.5), offset = pixel - seen.center;
  if (!seen.flat) return offset.dot(seen.from_offset * offset);
  // The low-pass: a Gaussian of √½ px about the projected centre.
  const double screen = 2.0 * offset.squaredNorm();
  const Vector3d ray((pixel.x() - view.center_x) / view.focal_x, (pixel.y() - view.center_y) / view.focal_y,
                     1.0);
  if (view.camera.orthographic) {
    // The ray is (x, y, z) for all z, and its disc in front where its mean is.
    if (seen.normal.z() == 0.0) return screen;
    const double x_off = ray.x() - seen.at.x(), y_off = ray.y() - seen.at.y();
    const Vector3d off(x_off, y_off, -(seen.normal.x() * x_off + seen.normal.y() * y_off) / seen.normal.z());
    const double u = seen.dual_u.dot(off), v = seen.dual_v.dot(off);
    return std::min(screen, u * u + v * v);
  }
  const double along = seen.normal.dot(ray);
  if (along == 0.0) return screen;
  const double depth = seen.normal.dot(seen.at) / along;
  if (!(depth > model_.near)) return screen;
  const Vector3d from_center = depth * ray - seen.at;
  const double u = seen.dual_u.dot(from_center), v = seen.dual_v.dot(from_center);
  return std::min(screen, u * u + v * v);
}

/// Of a splat in a pixel; 0: less than the least.
double Frame::alpha_at(const Seen& seen, const View& view, int x, int y) const {
  const double gauss = std::exp(-0.5 * distance_squared(seen, view, x, y));
  const double alpha = std::min(model_.most_alpha, seen.opacity * gauss);
  return alpha >= model_.least_alpha ? alpha : 0.0;
}

/// Behind what the pixel has. False: it is not drawn, and nothing behind it is.
bool Frame::blend(const Seen& seen, double alpha, Pixel& pixel) const {
  const double left = pixel.light * (1.0 - alpha);
  if (left < model_.least_light) {
    pixel.done = true;
    return false;
  }
  pixel.color += pixel.light * alpha * seen.color;
  pixel.depth += pixel.light * alpha * seen.depth;
  pixel.light = left;
  return true;
}

std::uint64_t Frame::draw(const View& view, int y_begin) {
  const int y_end = std::min(y_begin + band_rows, image_.y + image_.height);
  const auto pitch = static_cast<std::size_t>(image_.width);
  const auto index = [&](int x, int y) {
    return static_cast<std::size_t>(y - y_begin) * pitch + static_cast<std::size_t>(x - image_.x);
  };
  std::vector<Pixel> pixels(pitch * static_cast<std::size_t>(y_end - y_begin));
  std::uint64_t fragments = 0;
  for (const Seen& seen : seen_)
    for (int y = std::max(seen.y_begin, y_begin); y < std::min(seen.y_end, y_end); ++y)
      for (int x = seen.x_begin; x < seen.x_end; ++x) {
        Pixel& pixel = pixels[index(x, y)];
        if (pixel.done) continue;
        const double alpha = alpha_at(seen, view, x, y);
        if (alpha > 0.0 && blend(seen, alpha, pixel)) ++fragments;
      }
  PixelSum* sum = sums_.data() + static_cast<std::size_t>(y_begin - image_.y) * pitch;
  for (const Pixel& pixel : pixels) finish(pixel, *sum++);
  return fragments;
}

/// Model section 14.7, pixel by pixel: the splats between two surfaces are a picture of their own, from the
/// depth of the one up to that of the other, and all these pictures and surfaces lie over each other.
std::uint64_t Frame::draw_among_surfaces(const View& view, int y_begin) {
  const int y_end = std::min(y_begin + band_rows, image_.y + image_.height);
  std::uint64_t fragments = 0;
  for (int y = y_begin; y < y_end; ++y)
    for (int x = image_.x; x < image_.x + image_.width; ++x) {
      const std::vector<reference::Surface> surfaces = surfaces_.of_pixel(x, y);
      std::vector<Pixel> runs(surfaces.size() + 1);
      for (const Seen& seen : seen_) {
        if (y < seen.y_begin || y >= seen.y_end || x < seen.x_begin || x >= seen.x_end) continue;
        const double alpha = alpha_at(seen, view, x, y);
        for (std::size_t k = 0; k < runs.size() && alpha > 0.0; ++k) {
          const bool behind_last = k == 0 || seen.depth >= surfaces[k - 1].depth,
                     before_next = k == surfaces.size() || seen.depth < surfaces[k].depth;
          if (behind_last && before_next && !runs[k].done && blend(seen, alpha, runs[k])) ++fragments;
        }
      }
      // Colours from the back to the front, alpha and depth the other way round.
      Vector3d color = scene_.background.head<3>().cast<double>();
      for (std::size_t k = runs.size(); k-- > 0;) {
        for (int c = 0; c < 3; ++c) color[c] = covered(runs[k].color[c], runs[k].light, color[c]);
        if (k == 0) break;
        const reference::Surface& surface = surfaces[k - 1];
        color =
            surface.coverage * surface.color.head<3>() + (1.0 - surface.coverage * surface.color.w()) * color;
      }
      PixelSum& sum = sums_[static_cast<std::size_t>(y - image_.y) * static_cast<std::size_t>(image_.width) +
                            static_cast<std::size_t>(x - image_.x)];
      sum.color += color;
      double light = 1.0;
      for (std::size_t k = 0; k < runs.size(); ++k) {
        sum.depth += light * runs[k].depth;
        light *= runs[k].light;
        if (k == surfaces.size()) break;
        const double alpha = surfaces[k].coverage * surfaces[k].color.w();
        sum.depth += light * alpha * surfaces[k].depth;
        light *= 1.0 - alpha;
      }
      sum.alpha += 1.0 - light;
    }
  return fragments;
}

/// What is behind splats, one channel of light, with these over it.
double Frame::covered(double color, double light, double behind) const {
  return linear_ ? color + light * behind : decoded(color + light * encoded(behind));
}

/// Splats are blended over what is behind them in the values they were trained in.
void Frame::finish(const Pixel& pixel, PixelSum& sum) const {
  for (int c = 0; c < 3; ++c)
    sum.color[c] += covered(pixel.color[c], pixel.light, double{scene_.background[c]});
  sum.alpha += 1.0 - pixel.light;
  sum.depth += pixel.depth;
}

Status validate(const Scene& scene, const SplatReferenceOptions& options) {
  if (options.samples < 1 || options.samples > 1 << 20)
    return Error{"", "samples", "must be from 1 to 1048576, not " + std::to_string(options.samples)};
  if (options.threads < 0 || options.threads > 1024)
    return Error{"", "threads", "must be from 0 to 1024, not " + std::to_string(options.threads)};
  if (Status status = scene.validate(); !status) return status;
  const Object* first = nullptr;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Object& object = scene.objects[i];
    const std::string field = "/objects/" + std::to_string(i);
    if (object.splats.size() == 0) continue;
    if (first != nullptr && blends_linearly(scene, *first) != blends_linearly(scene, object))
      return Error{"", field,
                   "is blended in other values than another object's splats; say in which with "
                   "/splats/blending"};
    first = &object;
  }
  return refuse_row_delay(scene, "the reference of Gaussian splats");
}

Rendered render(const Scene& scene, const SplatReferenceOptions& options, const RenderControl& control) {
  const Exposure exposure = scene.exposure();
  const int samples = exposure.instant() ? 1 : options.samples;
  // Through each point of a lens all of these stills, from an eye there.
  std::optional<Scene> moved;
  if (scene.camera.aperture.radius > 0.0) {
    moved = scene;
    moved->camera.aperture = {};
  }
  const std::vector<Eigen::Vector2d> lens = lens_points(scene.camera.aperture, lens_point_count(scene));
  Frame sum(moved ? *moved : scene, control.stop);
  ProgressOf progress(control, lens.size() * static_cast<std::size_t>(samples));
  for (const Eigen::Vector2d& point : lens) {
    if (moved) moved->camera.lens_point = point;
    for (int i = 0; i < samples; ++i) {
      sum.add(exposure.at((i + 0.5) / samples));
      progress.one_more();
    }
  }
  Rendered rendered;
  rendered.image = sum.mean();
  double splats = 0.0;
  for (const Object& object : scene.objects) splats += static_cast<double>(object.splats.size());
  rendered.statistics.count("samples", samples);
  if (moved) rendered.statistics.count("lens_points", static_cast<double>(lens.size()));
  rendered.statistics.count("splats", splats);
  rendered.statistics.count("fragments", static_cast<double>(sum.fragments()));
  rendered.statistics.effect(samples == 1 ? "motion blur: skipped, for the shutter is closed or one sample"
                                          : "motion blur: " + std::to_string(samples) + " still images");
  return rendered;
}

}  // namespace

Result<Rendered> render_splat_reference(const Scene& scene, const SplatReferenceOptions& options,
                                        const RenderControl& control) {
  return without_throwing("to render the reference", [&]() -> Result<Rendered> {
    if (Status status = validate(scene, options); !status) return status.error();
    RenderControl threads = control;
    threads.threads = options.threads;
    Result<Rendered> rendered = run_in_arena(
        threads, [&]() -> Result<Rendered> { return render(scene, options, control); },
        "to render the reference");
    if (rendered && control.log)
      for (const std::string& effect : rendered->statistics.effects) call_back(control.log, effect);
    return rendered;
  });
}

}  // namespace swept
