#include "abuffer/splats/splat_frame.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "abuffer/parallel.h"
#include "abuffer/splats/splat_cell.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/splats/splat_row.h"
#include "splat/stopwatch.h"

namespace swept {
namespace {

/// Placed splats of so many bytes are held at once, or those of one instant.
constexpr std::size_t most_placed_bytes = std::size_t{512} << 20;

/// An instant that some cells want, at shutter time numerator / denominator.
struct WantedInstant {
  double time = 0.0;
  std::vector<char> cells;
};

class SplatFrame {
 public:
  SplatFrame(const Scene& scene, const SampledOptions& options, const RenderControl& control)
      : scene_(scene),
        options_(options),
        control_(control),
        exposure_(scene.exposure()),
        grid_(scene.film),
        math_(math_for(options)),
        rule_(splat_rule(scene)),
        painters_([this] { return SplatPainter(math_, rule_); }) {}

  Result<Rendered> render();

 private:
  static const SplatMath& math_for(const SampledOptions& options) {
    const SplatMaths maths = splat_maths();
    const std::size_t widest = maths.count - 1;
    return maths.first[options.implementation < 0
                           ? widest
                           : std::min(static_cast<std::size_t>(options.implementation), widest)];
  }

  const Scene& scene_;
  const SampledOptions& options_;
  const RenderControl& control_;
  Exposure exposure_;
  CellGrid grid_;
  const SplatMath& math_;
  SplatRule rule_;
  tbb::enumerable_thread_specific<SplatPainter> painters_;
};

Result<Rendered> SplatFrame::render() {
  const std::size_t bytes = packed_splat_bytes(scene_);
  if (control_.max_bytes > 0 && bytes > control_.max_bytes)
    return Error{"", "max_bytes", "the splats alone take " + std::to_string(bytes) + " bytes"};
  Stopwatch watch;
  Rendered out;
  const std::vector<SplatPackets> sets = pack_splats(scene_, exposure_, options_.only_standing);
  out.statistics.time("packets", watch.lap());
  out.image = blank_image(scene_.film);
  const std::vector<char> all(grid_.size(), 1);
  const SplatRow standing(scene_, sets, false, exposure_.open, math_, grid_, all);
  const int n = std::max(1, options_.samples);
  std::vector<SplatRow> rows;
  for (int i = 0; i < n; ++i) {
    rows.emplace_back(scene_, sets, true, exposure_.at((i + 0.5) / n), math_, grid_, all);
  }
  out.statistics.time("rows", watch.lap());
  parallel_for_each_index(grid_.size(), [&](std::size_t i) {
    auto sums = std::make_unique<CellOfSplats>();
    SplatPainter& painter = painters_.local();
    for (int k = 0; k < n; ++k)
      painter.add(grid_.cell(i), i, standing, rows[static_cast<std::size_t>(k)], {}, *sums);
    sums->store(grid_.cell(i), n, scene_.background[3], out.image);
  });
  out.statistics.time("cells", watch.lap());
  std::uint64_t looks = 0;
  for (const SplatPainter& p : painters_) looks += p.looks;
  out.statistics.count("looks", static_cast<double>(looks));
  return out;
}

}  // namespace

Result<Rendered> render_splats(const Scene& scene, const SampledOptions& options,
                               const RenderControl& control) {
  return SplatFrame(scene, options, control).render();
}

}  // namespace swept
