// A picture through a thin lens as the mean of pictures through its points. For the project's own sources.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "splat/lens_points.h"
#include "splat/render_control.h"
#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// Copies the scene once, and calls render(scene, control) for each of the lens's points, the scene having a
/// pinhole there and no background. Colours are averaged in linear light, depths by their alpha. Counts
/// are those of the first point, besides "lens_points", and times those of all.
template <class Render>
[[nodiscard]] Result<Rendered> render_through_lens(const Scene& scene, const RenderControl& control,
                                                   const Render& render) {
  const std::vector<Eigen::Vector2d> points = lens_points(scene.camera.aperture, lens_point_count(scene));
  const double per_point = 1.0 / static_cast<double>(points.size());
  Scene pinhole = scene;
  pinhole.camera.aperture = {};
  pinhole.background.setZero();
  Rendered out;
  std::vector<double> rgba, depth;
  for (std::size_t i = 0; i < points.size(); ++i) {
    pinhole.camera.lens_point = points[i];
    RenderControl part = control;
    if (control.progress)
      part.progress = [&](double done) { control.progress((static_cast<double>(i) + done) * per_point); };
    Result<Rendered> rendered = render(std::as_const(pinhole), std::as_const(part));
    if (!rendered) return rendered;
    const Image& image = rendered->image;
    rgba.resize(image.rgba.size());
    depth.resize(image.depth.size());
    for (std::size_t k = 0; k < rgba.size(); ++k) rgba[k] += double{image.rgba[k]};
    for (std::size_t k = 0; k < depth.size(); ++k)
      if (image.rgba[4 * k + 3] > 0.0f) depth[k] += double{image.rgba[4 * k + 3]} * double{image.depth[k]};
    if (i == 0)
      out = *std::move(rendered);
    else
      for (std::size_t k = 0; k < out.statistics.seconds.size() && k < rendered->statistics.seconds.size();
           ++k)
        out.statistics.seconds[k].second += rendered->statistics.seconds[k].second;
  }
  Image& image = out.image;
  for (std::size_t k = 0; k < depth.size(); ++k) {
    const double alpha = rgba[4 * k + 3];
    image.depth[k] =
        alpha > 0.0 ? static_cast<float>(depth[k] / alpha) : std::numeric_limits<float>::infinity();
    const double left = std::max(0.0, 1.0 - alpha * per_point);
    for (std::size_t c = 0; c < 4; ++c)
      image.rgba[4 * k + c] = static_cast<float>(rgba[4 * k + c] * per_point +
                                                 left * double{scene.background[static_cast<int>(c)]});
  }
  out.statistics.count("lens_points", static_cast<double>(points.size()));
  out.statistics.effect("depth of field: the mean over " + std::to_string(points.size()) +
                        " points of the lens");
  return out;
}

}  // namespace swept
