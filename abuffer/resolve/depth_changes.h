// Where one depth that is smooth in time passes through another. Source: model section 15; interpolation at
// Chebyshev's points.
//
// The depths of surfaces that are means over places have no polynomial of a low degree whose roots could be
// looked for. So their difference is looked at in six points, in halves until the polynomial through these is
// right elsewhere, too; and that one's roots are found as those within a mesh are, all of them: two may be
// missed that are less than 2√10⁻¹² of the piece apart, 2·10⁻⁶ of the light in it.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "splat/interval/bernstein.h"

namespace swept {

struct DepthChanges {
  static constexpr std::size_t points = 6, checks = 3;
  /// Of a depth less another one, at these shares of a piece of time.
  using Values = std::array<double, points + checks>;
  /// Chebyshev's, ½ − ½ cos(kπ/5), and between these where errors are largest.
  static constexpr Values places = {0.0,
                                    0.095491502812526288,
                                    0.34549150281252629,
                                    0.65450849718747371,
                                    0.90450849718747371,
                                    1.0,
                                    0.047745751406263144,
                                    0.5,
                                    0.95225424859373686};
  /// What the polynomial may be off by, as a share of the largest value.
  static constexpr double off = 1e-12;
  /// What rounding leaves open of a depth, as a share of it.
  static constexpr double rounding = 1e-14;

  /// Puts the polynomial through the first of `values` in Bernstein form. False: it is off at the others by
  /// more than 10⁻⁸ of the largest value and what rounding leaves open of depths as large as `depth`.
  [[nodiscard]] static bool fit(const Values& values, double depth, Bernstein& through);
  /// Appends when, of a piece of time, it changes its sign. What is 0 but for rounding does not.
  static void add(const Values& values, double depth, const Bernstein& through, double begin, double end,
                  std::vector<double>& times);

  /// Appends where, from `begin` to `end`, any of `count` differences changes its sign, in any order.
  /// look(time, place) fills column `place` of values(i), which `i`-th difference it has at that time;
  /// depth(i) is how large the depths are then. Pieces are halved `halvings` times at the most.
  template <class Look, class ValuesOf, class DepthOf>
  static void find(double begin, double end, int halvings, std::size_t count, const Look& look,
                   const ValuesOf& values, const DepthOf& depth, std::vector<double>& times) {
    for (std::size_t place = 0; place < places.size(); ++place)
      look(begin + (end - begin) * places[place], place);
    const std::size_t known = times.size();
    for (std::size_t i = 0; i < count; ++i) {
      Bernstein through;
      const Values of = values(i);
      const double scale = depth(i);
      if (!fit(of, scale, through) && halvings > 0) {
        times.resize(known);
        const double half = 0.5 * begin + 0.5 * end;
        find(begin, half, halvings - 1, count, look, values, depth, times);
        find(half, end, halvings - 1, count, look, values, depth, times);
        return;
      }
      add(of, scale, through, begin, end, times);
    }
  }
};

}  // namespace swept
