#include "abuffer/splats/share_instants.h"

#include <algorithm>
#include <limits>
#include <map>

namespace swept {

void share_instants(std::vector<CellWork>& cells, std::size_t splats) {
  // Of placing a splat, and of drawing a pixel, in the mean over trained files: their ratio is what counts.
  constexpr double place = 0.1, draw = 0.12;
  std::map<int, double> px;  // by number
  for (const CellWork& work : cells)
    if (work.adaptive) px[work.count] += double{1.0} * work.cell.width * work.cell.height;
  std::vector<int> counts;
  std::vector<double> below = {0.0};  // pixels of all smaller numbers
  for (const auto& [count, of_count] : px) {
    counts.push_back(count);
    below.push_back(below.back() + of_count);
  }
  // The cheapest for the first k numbers, and where its last group begins.
  std::vector<double> cost = {0.0};
  std::vector<std::size_t> first = {0};
  for (std::size_t k = 1; k <= counts.size(); ++k) {
    cost.push_back(std::numeric_limits<double>::infinity());
    first.push_back(0);
    for (std::size_t from = 0; from < k; ++from) {
      const double total = cost[from] + counts[k - 1] * (place * static_cast<double>(splats) +
                                                         draw * (below[k] - below[from]));
      if (total < cost[k]) cost[k] = total, first[k] = from;
    }
  }
  std::map<int, int> raised;
  for (std::size_t k = counts.size(); k > 0; k = first[k])
    for (std::size_t i = first[k]; i < k; ++i) raised[counts[i]] = counts[k - 1];
  for (CellWork& work : cells)
    if (work.adaptive) work.count = raised[work.count];
}

}  // namespace swept
