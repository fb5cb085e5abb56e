#include "splat/io/color_scale.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "splat/srgb.h"

namespace swept {
namespace {

constexpr double kByte = 255.0, kWord = 65535.0;

/// The finite numbers of some columns.
struct Extent {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();
  std::size_t above_1 = 0, not_zero = 0;
  bool whole = true;

  void add(const std::vector<double>& values) {
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      least = std::min(least, value);
      greatest = std::max(greatest, value);
      above_1 += value > 1.0;
      not_zero += value != 0.0;
      whole = whole && value == std::floor(value);
    }
  }
  [[nodiscard]] bool mostly_above_1() const { return 2 * above_1 > not_zero; }
};

std::string text_of(double value) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::string described(const char* what, const ColorScale& scale) {
  return std::string(what) + " from " + text_of(scale.least) + " to " + text_of(scale.full) +
         (scale.space == ColorSpace::srgb ? ", sRGB" : ", linear");
}

}  // namespace

double ColorScale::linear(double stored) const {
  return space == ColorSpace::srgb ? srgb_to_linear(channel(stored)) : channel(stored);
}

ColorScale color_scale(const std::vector<Column>& columns, const AttributePlan::Triple& color,
                       const std::vector<std::vector<double>>& values, const ReadOptions& options) {
  Extent extent;
  double type_full = 0.0;
  for (const std::size_t c : color) {
    extent.add(values[c]);
    type_full = std::max(type_full, columns[c].full_scale);
  }
  ColorScale scale;
  scale.full = type_full > 0.0 ? type_full : 1.0;
  const char* why = "";
  if (options.color_range) {
    scale.full = *options.color_range;
    why = ", as stated";
  } else if (type_full > kByte && extent.greatest <= kByte && extent.greatest > 0.0) {
    scale.full = kByte;
    why = ": no number exceeds 255, whatever the type holds";
  } else if (type_full == kByte && extent.greatest > kByte && extent.greatest <= kWord) {
    scale.full = kWord;
    why = ": numbers exceed 255";
  } else if (type_full == 0.0 && extent.mostly_above_1() && extent.greatest <= kByte) {
    scale.full = kByte;
    why = ": most numbers exceed 1";
  } else if (type_full == 0.0 && extent.mostly_above_1() && extent.whole && extent.greatest <= kWord) {
    scale.full = kWord;
    why = ": whole numbers beyond 255";
  }
  const bool is_light = type_full == 0.0 && scale.full == 1.0;
  scale.space = options.color_space.value_or(is_light ? ColorSpace::linear : ColorSpace::srgb);
  scale.assumed = described("colours", scale) + why;
  if (is_light && !options.color_range && extent.greatest > 1.0) {
    scale.assumed += "; some are brighter than 1 (color_range says what full is)";
  }
  return scale;
}

std::optional<ColorScale> grey_scale(const Column& column, const std::vector<double>& values,
                                     const ReadOptions& options) {
  Extent extent;
  extent.add(values);
  ColorScale scale;
  const char* why = "";
  if (options.color_range) {
    scale.full = *options.color_range;
    why = ", as stated";
  } else if (extent.least < 0.0) {
    if (extent.least < -2048.0 || extent.greatest > 2047.0) return std::nullopt;
    scale.least = -2048.0;
    scale.full = 2047.0;
  } else if (column.full_scale == kByte && extent.greatest <= kByte) {
    scale.full = kByte;
  } else {
    scale.full = std::max(1.0, extent.greatest);
    for (const double full : {1.0, kByte, 1023.0, 4095.0, 16383.0, kWord}) {
      if (extent.greatest > full) continue;
      scale.full = full;
      break;
    }
    why = ", by the greatest";
  }
  scale.space = options.color_space.value_or(ColorSpace::srgb);
  scale.assumed = described("intensities", scale) + why + ", shown as grey";
  return scale;
}

double alpha_full(const Column& column, const std::vector<double>& values, double color_full) {
  Extent extent;
  extent.add(values);
  if (column.full_scale > kByte && color_full == kByte && extent.greatest <= kByte) return kByte;
  if (column.full_scale > 0.0) return column.full_scale;
  return extent.greatest > 1.0 ? std::max(1.0, color_full) : 1.0;
}

}  // namespace swept
