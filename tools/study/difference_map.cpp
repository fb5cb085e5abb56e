#include "tools/study/difference_map.h"

#include <algorithm>
#include <cmath>

#include "splat/srgb.h"

namespace swept {
const std::vector<std::array<int, 3>>& difference_colors() {
  static const std::vector<std::array<int, 3>> colors = {
      {0, 0, 0},     {28, 12, 60},   {75, 15, 107}, {120, 28, 109}, {165, 44, 96},
      {207, 68, 70}, {237, 105, 37}, {251, 155, 6}, {247, 209, 60}, {252, 255, 190}};
  return colors;
}

Image difference_map(const Image& a, const Image& b) {
  const auto& colors = difference_colors();
  const double decades = std::log10(kDifferenceHigh / kDifferenceLow);
  Image map = a;
  for (std::size_t i = 0; i < map.pixel_count(); ++i) {
    double difference = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      difference = std::max(difference, std::abs(double{a.rgba[4 * i + c]} - double{b.rgba[4 * i + c]}));
    const double share =
        std::clamp(std::log10(std::max(difference, 1e-30) / kDifferenceLow) / decades, 0.0, 1.0);
    const double place = share * static_cast<double>(colors.size() - 1);
    const std::size_t below = std::min(static_cast<std::size_t>(place), colors.size() - 2);
    for (std::size_t c = 0; c < 3; ++c) {
      const double mix =
          std::lerp(colors[below][c], colors[below + 1][c], place - static_cast<double>(below));
      map.rgba[4 * i + c] = static_cast<float>(srgb_to_linear(mix / 255.0));
    }
    map.rgba[4 * i + 3] = 1.0f;
  }
  return map;
}

}  // namespace swept
