#include "abuffer/supersample.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "abuffer/abuffer.h"
#include "abuffer/render_valid.h"
#include "splat/motion/segments.h"
#include "splat/stopwatch.h"

namespace swept {
namespace {

/// Adds still images up in double, before there is a background.
class StillSum {
 public:
  void add(const Image& image) {
    rgba_.resize(image.rgba.size());
    depth_.resize(image.depth.size());
    for (std::size_t i = 0; i < rgba_.size(); ++i) rgba_[i] += static_cast<double>(image.rgba[i]);
    for (std::size_t i = 0; i < depth_.size(); ++i)
      if (const double alpha = image.rgba[4 * i + 3]; alpha > 0.0)
        depth_[i] += alpha * static_cast<double>(image.depth[i]);
  }

  /// Over `background`, into `image`, which has the window's size.
  void mean(int count, const Eigen::Vector4d& background, Image& image) const {
    for (std::size_t i = 0; i < depth_.size(); ++i) {
      const double alpha = rgba_[4 * i + 3];
      image.depth[i] =
          alpha > 0.0 ? static_cast<float>(depth_[i] / alpha) : std::numeric_limits<float>::infinity();
      const double left = std::max(0.0, 1.0 - alpha / count);
      for (std::size_t c = 0; c < 4; ++c)
        image.rgba[4 * i + c] = static_cast<float>(rgba_[4 * i + c] / count + left * background[c]);
    }
  }

 private:
  std::vector<double> rgba_, depth_;
};

Result<Rendered> render_checked(const Scene& scene, const SupersampleOptions& options) {
  Stopwatch watch;
  Scene instant = scene;
  instant.background.setZero();
  AbufferOptions still;
  still.threads = options.threads;
  const int instants = nothing_moves(scene, scene.exposure()) ? 1 : options.samples;
  const double length = scene.shutter.close - scene.shutter.open;

  StillSum sum;
  Image image;
  double fragments = 0.0;
  for (int i = 0; i < instants; ++i) {
    const double time = scene.shutter.open + length * ((i + 0.5) / instants);
    instant.shutter = {time, time};
    Result<Rendered> rendered = render_abuffer(instant, still);
    if (!rendered) return rendered.error();
    sum.add(rendered->image);
    fragments += rendered->statistics.counter("fragments").value_or(0.0);
    image = std::move(rendered->image);
  }
  sum.mean(instants, scene.background.cast<double>(), image);

  Rendered out{std::move(image), {}};
  out.statistics.count("samples", options.samples);
  out.statistics.count("instants", instants);
  out.statistics.count("fragments", fragments);
  out.statistics.time("stills", watch.lap());
  out.statistics.effect(instants > 1 ? "motion blur: the mean of still images"
                                     : "motion blur: skipped, nothing moves during the exposure");
  return out;
}

}  // namespace

Status SupersampleOptions::validate() const {
  if (samples < 1 || samples > 1 << 20) return Error{"", "samples", "must be in [1, 1048576]"};
  if (threads < 0 || threads > 1024) return Error{"", "threads", "must be in [0, 1024]"};
  return Done{};
}

Result<Rendered> render_supersampled(const Scene& scene, const SupersampleOptions& options) {
  return render_valid(scene, options, render_checked);
}

}  // namespace swept
