#include "abuffer/stochastic/stochastic.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "abuffer/hierarchy/traverse_hierarchy.h"
#include "abuffer/parallel.h"
#include "abuffer/progress_of.h"
#include "abuffer/render_valid.h"
#include "abuffer/stochastic/choose_traversal.h"
#include "abuffer/stochastic/primitives.h"
#include "abuffer/stochastic/traverse.h"
#include "splat/motion/segments.h"
#include "splat/stopwatch.h"

namespace swept {

using namespace stochastic;

namespace {

/// Side of the squares that threads share out, px.
constexpr int block_px = 16;
/// What interleave takes where nothing is said; Gribel et al. 2013, section 6.1.
constexpr int chosen_times = 256;

/// Which primitives may be seen in each block at any time.
class Bins {
 public:
  /// Null: none in any.
  Bins(const Primitives* primitives, const PixelRange& window)
      : window_(window), columns_(blocks(window.x1 - window.x0)), rows_(blocks(window.y1 - window.y0)) {
    std::vector<PixelRange> ranges(primitives != nullptr ? primitives->size() : 0);
    parallel_for_each_index(ranges.size(), [&](std::size_t i) {
      primitives->with(i, [&](const auto& primitive) { ranges[i] = primitive.pixels({0.0, 1.0}, window); });
    });
    starts_.assign(size() + 1, 0);
    const auto for_each_block = [&](const auto& visit) {
      for (std::size_t i = 0; i < ranges.size(); ++i) {
        if (i % 4096 == 0 && tbb::is_current_task_group_canceling()) throw Stopped();
        const PixelRange& range = ranges[i];
        if (range.empty()) continue;
        for (int y = (range.y0 - window.y0) / block_px; y <= (range.y1 - 1 - window.y0) / block_px; ++y)
          for (int x = (range.x0 - window.x0) / block_px; x <= (range.x1 - 1 - window.x0) / block_px; ++x)
            visit(static_cast<std::size_t>(y) * columns_ + static_cast<std::size_t>(x), i);
      }
    };
    for (const PixelRange& range : ranges) seen_ += range.empty() ? 0 : 1;
    for_each_block([&](std::size_t block, std::size_t) { ++starts_[block + 1]; });
    for (std::size_t b = 0; b < size(); ++b) starts_[b + 1] += starts_[b];
    entries_.resize(starts_.back());
    std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
    for_each_block(
        [&](std::size_t block, std::size_t i) { entries_[next[block]++] = static_cast<std::uint32_t>(i); });
  }

  [[nodiscard]] std::size_t size() const { return columns_ * rows_; }
  [[nodiscard]] std::size_t seen() const { return seen_; }
  [[nodiscard]] Window window(std::size_t block) const {
    const int x = window_.x0 + static_cast<int>(block % columns_) * block_px,
              y = window_.y0 + static_cast<int>(block / columns_) * block_px;
    return {x, y, std::min(block_px, window_.x1 - x), std::min(block_px, window_.y1 - y)};
  }
  template <class Visit>
  void for_each(std::size_t block, const Visit& visit) const {
    for (std::size_t k = starts_[block]; k < starts_[block + 1]; ++k) visit(entries_[k]);
  }

 private:
  static std::size_t blocks(int px) { return (static_cast<std::size_t>(px) + block_px - 1) / block_px; }

  PixelRange window_;
  std::size_t columns_, rows_, seen_ = 0;
  std::vector<std::size_t> starts_;
  std::vector<std::uint32_t> entries_;
};

void cut_exposure(const SampleSource& source, int parts, Block& block) {
  block.share_cuts.clear(), block.time_cuts.clear();
  for (int i = 0; i <= parts; ++i) {
    const double share = static_cast<double>(i) / parts;
    block.share_cuts.push_back(share);
    block.time_cuts.push_back(double{source.time_of(share)});
  }
}

/// Composes the block's pixels and puts them into the image.
void develop(const Scene& scene, Block& block, Image& image) {
  const SurfaceModel model(scene.model);
  const Window& window = block.samples.window;
  const double per_sample = 1.0 / block.samples.per_pixel;
  block.hits.finish();
  for (int y = window.y; y < window.y + window.height; ++y)
    for (int x = window.x; x < window.x + window.width; ++x) {
      block.worked(static_cast<std::uint64_t>(block.samples.per_pixel));
      const PixelSum pixel =
          block.hits.compose(block.first_of(x, y), static_cast<std::size_t>(block.samples.per_pixel), model);
      const std::size_t i = static_cast<std::size_t>(y - image.y) * static_cast<std::size_t>(image.width) +
                            static_cast<std::size_t>(x - image.x);
      const double alpha = pixel.rgba[3] * per_sample, left = std::max(0.0, 1.0 - alpha);
      for (int c = 0; c < 4; ++c)
        image.rgba[4 * i + static_cast<std::size_t>(c)] =
            static_cast<float>(pixel.rgba[c] * per_sample + left * double{scene.background[c]});
      image.depth[i] = pixel.rgba[3] > 0.0 ? static_cast<float>(pixel.depth / pixel.rgba[3])
                                           : std::numeric_limits<float>::infinity();
    }
}

std::string name_of(const StochasticOptions& options) {
  switch (options.traversal) {
    case Traversal::tile:
      return std::to_string(options.tile_px).append(" px tiles");
    case Traversal::interval:
      return std::to_string(options.intervals).append(" parts of the exposure");
    case Traversal::interleave:
      return "shared instants";
    case Traversal::hierarchy:
      return "hierarchy";
    case Traversal::automatic:
      break;
  }
  return "none";
}

Result<Rendered> render_checked(const Scene& scene, const StochasticOptions& given,
                                const RenderControl& control) {
  Stopwatch watch;
  const Exposure exposure = scene.exposure();
  StochasticOptions options = given;
  if (options.traversal == Traversal::interleave && options.times == 0) options.times = chosen_times;
  const bool lens = scene.camera.aperture.radius > 0.0;
  const bool triangles = std::any_of(scene.objects.begin(), scene.objects.end(),
                                     [](const Object& o) { return !o.triangles.empty(); });
  if (!lens && !triangles && nothing_moves(scene, exposure)) options.samples = 1;

  const SampleSource source(scene, exposure, options.samples, options.times);
  const FilmView view{projection_of(scene.film, scene.camera.at(exposure.middle())), scene.camera.near,
                      source.reach()};
  constexpr const char* memory = "kernels and paths";
  // A disc has a kernel at least.
  std::size_t discs = 0;
  for (const Object& object : scene.objects) discs += object.discs();
  if (Status fits = check_bytes(discs * sizeof(MovingKernel), control, memory); !fits) return fits.error();
  const Result<Primitives> found = Primitives::of(scene, exposure, view, control.stop);
  if (!found) return found.error();
  const Primitives& primitives = *found;
  if (Status fits = check_bytes(primitives.bytes(), control, memory); !fits) return fits.error();
  Rendered out;
  Statistics& statistics = out.statistics;
  statistics.time("paths", watch.lap());
  out.image = blank_image(scene.film);
  const PixelRange window{out.image.x, out.image.y, out.image.x + out.image.width,
                          out.image.y + out.image.height};
  if (options.traversal == Traversal::automatic) {
    const TraversalForecast forecast = forecast_traversals(primitives, window, options, source);
    options.traversal = forecast.by_intervals() ? Traversal::interval : Traversal::tile;
    statistics.count("forecast_tile_us", forecast.tile);
    statistics.count("forecast_interval_us", forecast.interval);
    statistics.time("forecast", watch.lap());
  }
  const bool by_hierarchy = options.traversal == Traversal::hierarchy;
  std::optional<hierarchy::HierarchyTraversal> trees;
  if (by_hierarchy) trees.emplace(primitives);
  const Bins bins(by_hierarchy ? nullptr : &primitives, window);
  statistics.time(by_hierarchy ? "hierarchy" : "bins", watch.lap());

  PerThread<Block> blocks;
  ProgressOf progress(control, bins.size());
  parallel_for_each_index(bins.size(), [&](std::size_t b) {
    Block& block = blocks.local();
    if (block.share_cuts.empty()) cut_exposure(source, options.intervals, block);
    source.fill(bins.window(b), block.samples);
    block.hits.start(block.samples.x.size());
    if (trees) trees->run(options.tile_px, block);
    bins.for_each(b, [&](std::size_t i) {
      primitives.with(i, [&](auto& primitive) { traverse(primitive, options, source, block); });
    });
    develop(scene, block, out.image);
    progress.one_more();
  });
  statistics.time("samples", watch.lap());

  TraversalCounts counts;
  for (const Block& block : blocks) {
    counts.tested += block.counts.tested;
    counts.inside += block.counts.inside;
    counts.bounds += block.counts.bounds;
  }
  statistics.count("samples", options.samples);
  statistics.count("primitive_bytes", static_cast<double>(primitives.bytes()));
  statistics.count("primitives", static_cast<double>(by_hierarchy ? primitives.size() : bins.seen()));
  statistics.count("samples_tested", static_cast<double>(counts.tested));
  statistics.count("samples_inside", static_cast<double>(counts.inside));
  statistics.count(
      "sample_test_efficiency",
      counts.tested > 0 ? static_cast<double>(counts.inside) / static_cast<double>(counts.tested) : 0.0);
  statistics.count("bounds_tested", static_cast<double>(counts.bounds));
  statistics.effect("motion blur" + std::string(lens ? " and depth of field: " : ": ") +
                    std::to_string(options.samples) + " samples a pixel" +
                    (options.times > 0 ? ", at " + std::to_string(options.times) + " instants in all" : ""));
  statistics.effect(name_of(options)
                        .insert(0, "traversal: ")
                        .append(given.traversal == Traversal::automatic ? ", by a forecast" : ""));
  return out;
}

}  // namespace

Status StochasticOptions::validate() const {
  if (samples < 1 || samples > 1 << 16) return Error{"", "samples", "must be in [1, 65536]"};
  if (times < 0 || times > 65536) return Error{"", "times", "must be in [0, 65536]"};
  if (tile_px != 1 && tile_px != 2 && tile_px != 4 && tile_px != 8 && tile_px != 16)
    return Error{"", "tile_px", "must be 1, 2, 4, 8 or 16"};
  if (intervals < 1 || intervals > 1024) return Error{"", "intervals", "must be in [1, 1024]"};
  if (traversal == Traversal::hierarchy && !hierarchy_available())
    return Error{"", "traversal", "this build leaves the hierarchy of moving boxes out (SWEPT_HIERARCHY)",
                 ErrorKind::unsupported};
  return Done{};
}

Result<Rendered> render_stochastic(const Scene& scene, const StochasticOptions& options,
                                   const RenderControl& control) {
  if (Status status = refuse_splats(scene, "the stochastic method"); !status) return status.error();
  if (Status status = refuse_row_delay(scene, "the stochastic method"); !status) return status.error();
  if (scene.camera.orthographic && options.traversal == Traversal::hierarchy)
    return Error{"", "traversal", "the hierarchy's rays begin in the eye, and the camera is orthographic",
                 ErrorKind::unsupported};
  return render_valid(scene, options, control, render_checked);
}

}  // namespace swept
