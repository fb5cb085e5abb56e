// FLIP: how different two images look to somebody who flips back and forth between them.
//
// Source: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild: FLIP: A Difference Evaluator
// for Alternating Images (2020), the metric for images of low dynamic range. A pixel's value is the distance
// of two colours, each blurred as far as an eye at that distance blurs it, raised to a power that falls where
// an edge or a point is in one image and not in the other.
#pragma once

#include <vector>

#include "splat/export.h"
#include "splat/image.h"

namespace SWEPT_API swept {

/// What an observer 0.7 m in front of a 0.7 m wide monitor of 3840 pixels has, as in the paper.
inline constexpr double kFlipPixelsPerDegree = 67.0;

/// FLIP per pixel, in [0, 1], rows top to bottom; 0 where nothing differs. Symmetric in `a` and `b`.
///
/// The paper takes images encoded as sRGB and decodes them. Ours are linear, so nothing is decoded: sRGB
/// enters only as what R, G and B mean, its primaries and white (Rec.709 and D65). Values are RGB as
/// stored, that is over black, clamped to [0, 1]; alpha and depth are not seen. Beyond the border the
/// outermost pixels repeat, as in the authors' own programs; the paper says nothing of it.
///
/// A pixel that is not finite in either image, alpha included, leaves no value (NaN) for any pixel whose
/// filters reach it, which is a square of ⌈0.13505 · pixels_per_degree⌉ px to each side.
///
/// `a` and `b` must be valid and of equal width and height; pixels_per_degree in [1, 10⁴].
[[nodiscard]] std::vector<double> flip_map(const Image& a, const Image& b,
                                           double pixels_per_degree = kFlipPixelsPerDegree);

/// The mean of flip_map over the pixels that have a value; NaN if there is none.
[[nodiscard]] double mean_flip(const Image& a, const Image& b,
                               double pixels_per_degree = kFlipPixelsPerDegree);

/// The mean of what flip_map returned.
[[nodiscard]] double mean_flip(const std::vector<double>& map);

}  // namespace swept
