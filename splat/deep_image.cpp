#include "splat/deep_image.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>

#include "splat/without_throwing.h"

namespace swept {
namespace {

/// Of a pixel's light. What adds less goes with what is next to it.
constexpr double least_share = 0x1p-20;
constexpr float farthest = std::numeric_limits<float>::max();

/// Light of a sample, seen in the picture as it is.
struct Seen {
  double rgba[4] = {0.0, 0.0, 0.0, 0.0};

  void add(const Seen& other) {
    for (int c = 0; c < 4; ++c) rgba[c] += other.rgba[c];
  }
};

void append_sample(const Seen& seen, double& left, float near, float far, DeepImage& image) {
  // Of what is left; rounding may have it that less is.
  const double light = std::max(left, seen.rgba[3]);
  for (const double value : seen.rgba) image.rgba.push_back(static_cast<float>(value / light));
  image.depth.push_back(near);
  image.depth.push_back(far);
  left -= seen.rgba[3];
}

}  // namespace

void append_pixel(const std::vector<DepthPart>& parts, double scale, const Eigen::Vector4d& background,
                  DeepImage& image) {
  if (image.first.empty()) image.first.push_back(0);
  double left = 1.0;
  Seen waiting;
  const std::size_t start = image.rgba.size();
  const DepthPart* thin = nullptr;  // the last of those that wait
  for (const DepthPart& part : parts) {
    for (int c = 0; c < 4; ++c) waiting.rgba[c] += scale * double{part.rgba[c]};
    thin = &part;
    if (!(waiting.rgba[3] > least_share)) continue;
    append_sample(waiting, left, part.near, part.far, image);
    waiting = {};
    thin = nullptr;
  }
  // Nothing is behind what waits still: it goes with the last sample, or is one.
  if (thin != nullptr && waiting.rgba[3] != 0.0) {
    if (image.rgba.size() > start) {
      const std::size_t last = image.rgba.size() - 4;
      Seen sample;
      left = 1.0;
      for (std::size_t i = start; i < last; i += 4) left *= 1.0 - double{image.rgba[i + 3]};
      for (std::size_t c = 0; c < 4; ++c) sample.rgba[c] = left * double{image.rgba[last + c]};
      sample.add(waiting);
      const float near = image.depth[image.depth.size() - 2], far = image.depth.back();
      image.rgba.resize(last);
      image.depth.resize(image.depth.size() - 2);
      append_sample(sample, left, near, far, image);
    } else if (waiting.rgba[3] > 0.0) {
      append_sample(waiting, left, thin->near, thin->far, image);
    }
  }
  if (!background.isZero(0.0)) {
    for (int c = 0; c < 4; ++c) image.rgba.push_back(static_cast<float>(background[c]));
    image.depth.insert(image.depth.end(), 2, farthest);
  }
  image.first.push_back(image.rgba.size() / 4);
}

Status DeepImage::validate() const {
  return without_throwing("to check the deep image", [&]() -> Status {
    if (width < 1 || height < 1) return Error{"", "width, height", "an image needs at least one pixel"};
    if (film_width < 1 || film_height < 1)
      return Error{"", "film_width, film_height", "a film needs at least one pixel"};
    constexpr std::int64_t most = std::numeric_limits<int>::max();
    if (std::int64_t{x} + width > most || std::int64_t{y} + height > most)
      return Error{"", "x, y", "the window's far corner is beyond the range of a pixel coordinate"};
    if (first.size() != pixel_count() + 1 || first.front() != 0 ||
        !std::is_sorted(first.begin(), first.end()))
      return Error{"", "first", "must hold the first sample of every pixel and the count of all, in order"};
    if (rgba.size() != 4 * sample_count()) return Error{"", "rgba", "must hold four values for a sample"};
    if (depth.size() != 2 * sample_count()) return Error{"", "depth", "must hold two values for a sample"};
    for (std::size_t pixel = 0; pixel < pixel_count(); ++pixel)
      for (std::size_t i = first[pixel]; i < first[pixel + 1]; ++i) {
        const float near = depth[2 * i], far = depth[2 * i + 1];
        if (!(near > 0.0f && near <= far && std::isfinite(far)))
          return Error{"", "depth",
                       "sample " + std::to_string(i) + " must go from one depth above 0 to another"};
        const bool follows = i == first[pixel] || near > depth[2 * i - 1] ||
                             (near == depth[2 * i - 1] && near > depth[2 * i - 2]);
        if (!follows)
          return Error{"", "depth", "sample " + std::to_string(i) + " overlaps the one before it"};
      }
    return Done{};
  });
}

}  // namespace swept
