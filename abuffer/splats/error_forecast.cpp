#include "abuffer/splats/error_forecast.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace swept {
namespace {

/// One pixel of so many each way is looked at.
constexpr int line_pitch_px = 2 * FilmMotion::pitch_px;

/// Numbers of instants that are thought of, odd ones, so that the middle is among them; and half of each by
/// interpolation.
constexpr std::array counts = {1,  3,  5,  7,  9,  11, 13, 15, 17, 19,  21,  25,
                               29, 33, 37, 41, 49, 57, 65, 81, 97, 113, 129, 161};

/// What is begun with is expected to be so much better than asked for: what ways do not tell of, colours that
/// turn and splats that come out from behind others, has to fit in.
constexpr double margin = 2.0;

/// Squares are taken to fall at most to this from N/2 to N, whatever the still says.
constexpr double least_fall = 0.02;
/// Splats that change their order jump. Where that could matter, squares are taken to fall by no more than
/// those of ErrorEstimate::of_splats.
constexpr double fall_of_jumps = 0.15;
/// What was not foreseen is taken for jumps.
constexpr double fall_of_surprise = 0.15, foreseen = 1.5;

using Color = std::array<float, 4>;

std::array<float, 4> cubic(float t) {
  return {((2.0f - t) * t - 1.0f) * t * 0.5f, ((3.0f * t - 5.0f) * t * t + 2.0f) * 0.5f,
          ((4.0f - 3.0f * t) * t + 1.0f) * t * 0.5f, (t - 1.0f) * t * t * 0.5f};
}

/// The still at a place on the film, pixel centres being whole numbers (Catmull-Rom).
Color still_at(const FilmStill& still, float x, float y) {
  const int left = static_cast<int>(x), top = static_cast<int>(y);
  const std::array<float, 4> wx = cubic(x - static_cast<float>(left)),
                             wy = cubic(y - static_cast<float>(top));
  Color sum = {};
  for (int j = 0; j < 4; ++j) {
    const int row = std::clamp(top + j - 1, 0, still.height - 1);
    for (int i = 0; i < 4; ++i) {
      const int column = std::clamp(left + i - 1, 0, still.width - 1);
      const float w = wx[static_cast<std::size_t>(i)] * wy[static_cast<std::size_t>(j)];
      const float* const from =
          &still.rgba[4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(still.width) +
                           static_cast<std::size_t>(column))];
      for (std::size_t c = 0; c < 4; ++c) sum[c] += w * from[c];
    }
  }
  return sum;
}

/// The part of a way over the film, and the still along it.
struct Line {
  double share = 0.0;      ///< of the way
  double length_px = 0.0;  ///< of the part
  std::vector<Color> colors;

  [[nodiscard]] Color at(float place) const {
    const float p = place * static_cast<float>(colors.size() - 1);
    const int first = static_cast<int>(p);
    const std::array<float, 4> w = cubic(p - static_cast<float>(first));
    Color sum = {};
    for (int i = 0; i < 4; ++i) {
      const int k = std::clamp(first + i - 1, 0, static_cast<int>(colors.size()) - 1);
      for (std::size_t c = 0; c < 4; ++c)
        sum[c] += w[static_cast<std::size_t>(i)] * colors[static_cast<std::size_t>(k)][c];
    }
    return sum;
  }
  /// Squares over R, G, B of what `count` instants are off by.
  [[nodiscard]] double squares(int count, double dilation_px2) const;
};

double Line::squares(int count, double dilation_px2) const {
  // A still has no frequencies beyond half of one a pixel. What lies there falls as the least splat's does.
  const double wanted = 2.0 * count * share, most = std::max(2.0, std::floor(0.8 * length_px));
  const int places = std::max(2, static_cast<int>(std::lround(std::min(wanted, most))));
  double unseen = 1.0;
  if (wanted > most) {
    const double f = 0.5 * wanted / length_px, seen = 0.5 * most / length_px;
    unseen = std::exp(-4.0 * std::numbers::pi * std::numbers::pi * dilation_px2 * (f * f - seen * seen));
  }
  std::array<double, 3> sum = {};
  for (int j = 0; j < places; ++j) {
    const Color color = at((static_cast<float>(j) + 0.5f) / static_cast<float>(places));
    const double weight = (j % 2 == 0 ? 1.0 : -1.0) * (j == 0 || j == places - 1 ? 0.5 : 1.0);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += weight * double{color[c]};
  }
  // Of a part of the way as much in the mean of all phases as of the whole: the fewer places, the more.
  return unseen * (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]) / (places * std::max(wanted, 1.0));
}

/// Through (x, y). Nothing where most of the way is beyond the film.
std::optional<Line> line_through(const FilmStill& still, const FilmMotion::Way& way, double x, double y) {
  const std::array<double, 2> by = {double{way.x}, double{way.y}};
  const std::array<double, 2> last = {still.width - 1.0, still.height - 1.0};
  std::array<double, 2> from = {x - 0.5 * by[0], y - 0.5 * by[1]};
  double begin = 0.0, end = 1.0;
  for (std::size_t a = 0; a < 2; ++a) {
    if (std::abs(by[a]) <= last[a]) {
      // The same texture is beside.
      from[a] = std::clamp(from[a], std::max(0.0, -by[a]), last[a] - std::max(0.0, by[a]));
      continue;
    }
    const double one = -from[a] / by[a], other = (last[a] - from[a]) / by[a];
    begin = std::max(begin, std::min(one, other)), end = std::min(end, std::max(one, other));
  }
  constexpr double enough = 0.6;
  if (!(end - begin >= enough)) return std::nullopt;
  Line line;
  line.share = end - begin;
  line.length_px = line.share * std::hypot(by[0], by[1]);
  const auto places = static_cast<std::size_t>(std::clamp(std::ceil(line.length_px) + 1.0, 4.0, 4096.0));
  line.colors.reserve(places);
  for (std::size_t i = 0; i < places; ++i) {
    const double t = begin + line.share * static_cast<double>(i) / static_cast<double>(places - 1);
    line.colors.push_back(
        still_at(still, static_cast<float>(from[0] + t * by[0]), static_cast<float>(from[1] + t * by[1])));
  }
  return line;
}

}  // namespace

double CellForecast::expected(double seen, double jumps) const {
  const double smooth = std::min(seen, foreseen * at_half), rest = seen - smooth;
  const double fall = at_half > 0.0 ? std::max(at_count / at_half, least_fall) : fall_of_jumps;
  return std::max(smooth * fall + rest * fall_of_surprise, std::min(fall_of_jumps * seen, jumps));
}

std::optional<CellForecast> ErrorForecast::of(const Cell& cell, std::size_t index,
                                              double allowed_mean_square) const {
  std::vector<Line> lines;
  std::size_t looked = 0, beyond = 0;
  constexpr int first = line_pitch_px / 2 - 1;
  for (int y = cell.y + first; y < cell.y + cell.height; y += line_pitch_px)
    for (int x = cell.x + first + (y / line_pitch_px % 2) * line_pitch_px; x < cell.x + cell.width;
         x += 2 * line_pitch_px) {
      ++looked;
      const FilmMotion::Way way = motion_.way(x, y);
      if (std::hypot(way.x, way.y) < 1e-3f) continue;
      if (std::optional<Line> line = line_through(still_, way, x, y))
        lines.push_back(std::move(*line));
      else
        ++beyond;
    }
  if (looked == 0 || 2 * beyond > looked) return std::nullopt;
  std::array<double, counts.size()> known;
  known.fill(-1.0);
  const auto mean_square = [&](std::size_t k) {
    if (known[k] >= 0.0) return known[k];
    known[k] = 0.0;
    for (const Line& line : lines) known[k] += line.squares(counts[k], dilation_px2_);
    known[k] /= 3.0 * static_cast<double>(looked - beyond);
    // Of near jumps a third is the mean over the times at which they may be.
    return known[k] += (motion_.jumps_of(index) + motion_.near_jumps_of(index) / 3.0) /
                       (double{1.0} * counts[k] * counts[k]);
  };
  const auto enough = [&](std::size_t k) { return margin * mean_square(k) <= allowed_mean_square; };
  // The least that is enough: between `few` and `many`.
  std::size_t few = 0, many = 1;
  while (!enough(many)) {
    if (many == counts.size() - 1) return std::nullopt;
    few = many, many = std::min(2 * many, counts.size() - 1);
  }
  while (many - few > 1) {
    const std::size_t middle = (few + many) / 2;
    (enough(middle) ? many : few) = middle;
  }
  // Half of it, between those that are known, on the logarithm's scale.
  const double half = 0.5 * counts[many];
  std::size_t above = 0;
  while (counts[above] < half) ++above;
  const double share = (half - counts[above - 1]) / (counts[above] - counts[above - 1]);
  return CellForecast{counts[many],
                      std::pow(mean_square(above - 1), 1.0 - share) * std::pow(mean_square(above), share),
                      mean_square(many)};
}

}  // namespace swept
