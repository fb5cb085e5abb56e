#include "abuffer/sampled.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <tbb/enumerable_thread_specific.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "abuffer/parallel.h"
#include "abuffer/resolve/sample_plan.h"
#include "abuffer/resolve/sampled_cell.h"
#include "abuffer/simd/sampled_math.h"
#include "abuffer/sources/object_instant.h"
#include "abuffer/sources/point_packets.h"
#include "abuffer/tiles/cells.h"
#include "splat/stopwatch.h"

namespace swept {
namespace {

/// Doubling leaves most cells better than they need be, so that each may have so much more than its share.
/// The fewer cells there are, the less can be relied on that.
[[nodiscard]] double slack(double moving_cells) { return 1.0 + 2.5 * moving_cells / (moving_cells + 24.0); }

/// Instants are doubled at most to so many.
constexpr int most_chosen = 1 << 14;

/// All objects at a row of instants, made once and shared by the cells.
class InstantTable {
 public:
  InstantTable(const Scene& scene, const Exposure& exposure, const std::vector<PointPackets>& objects)
      : scene_(scene), exposure_(exposure), objects_(objects) {}

  /// The objects at shutter time `numerator` / `denominator`.
  std::shared_ptr<const std::vector<ObjectInstant>> at(int numerator, int denominator) {
    const std::lock_guard lock(mutex_);
    auto& entry = instants_[{numerator, denominator}];
    if (!entry) {
      auto made = std::make_shared<std::vector<ObjectInstant>>();
      made->reserve(objects_.size());
      const double frame = exposure_.at(static_cast<double>(numerator) / denominator);
      for (const PointPackets& object : objects_) made->emplace_back(scene_, object, frame);
      entry = std::move(made);
    }
    return entry;
  }

 private:
  const Scene& scene_;
  Exposure exposure_;
  const std::vector<PointPackets>& objects_;
  std::mutex mutex_;
  std::map<std::pair<int, int>, std::shared_ptr<const std::vector<ObjectInstant>>> instants_;
};

struct CellResult {
  int instants = 0;
  double squares = 0.0;  ///< expected, of R, G and B
};

class Renderer {
 public:
  Renderer(const Scene& scene, const SampledOptions& options, const RenderControl& control)
      : scene_(scene), options_(options), control_(control), exposure_(scene.exposure()) {}

  Result<Rendered> render() {
    const std::size_t bytes = packed_bytes(scene_, exposure_);
    if (control_.max_bytes > 0 && bytes > control_.max_bytes)
      return Error{"", "max_bytes", "the points alone take " + std::to_string(bytes) + " bytes"};
    Stopwatch watch;
    Rendered out;
    const std::vector<PointPackets> objects = pack_points(scene_, exposure_, options_.only_standing);
    out.statistics.time("packets", watch.lap());
    const PacketBins bins(scene_, exposure_, objects);
    out.statistics.time("bins", watch.lap());
    out.image = blank_image(scene_.film);
    image_ = &out.image;
    bins_ = &bins;
    plan();

    const SampledMaths maths = sampled_maths();
    const std::size_t which =
        options_.implementation < 0
            ? maths.count - 1
            : std::min(static_cast<std::size_t>(options_.implementation), maths.count - 1);
    InstantTable table(scene_, exposure_, objects);
    tbb::enumerable_thread_specific<SampledCell> cells(
        [&] { return SampledCell(scene_, objects, maths.first[which]); });
    results_.resize(window_cells_.size());
    std::atomic<std::size_t> done{0};
    std::mutex progress_mutex;
    double told = 0.0;
    parallel_for_parts(tbb::blocked_range<std::size_t>(0, window_cells_.size(), 1), [&](const auto& range) {
      SampledCell& cell = cells.local();
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        if (control_.stop.stop_requested()) return;
        results_[i] = render_cell(window_cells_[i], cell, table);
        if (!control_.progress) continue;
        const double share =
            static_cast<double>(done.fetch_add(1) + 1) / static_cast<double>(window_cells_.size());
        const std::lock_guard lock(progress_mutex);
        if (share > told) control_.progress(told = share);
      }
    });
    if (control_.stop.stop_requested()) return Error{"", "", "the render was stopped"};
    out.statistics.time("cells", watch.lap());
    SampledCounters total;
    for (const SampledCell& cell : cells) total.add(cell.counters);
    describe(objects, total, maths.first[which], out.statistics);
    for (std::size_t i = 0; i < results_.size(); ++i) {
      const Cell cell = bins.cell(window_cells_[i]);
      out.parts.push_back({cell.x, cell.y, cell.width, cell.height, results_[i].instants});
    }
    return out;
  }

 private:
  /// Cells of the window, and how much error each that moves may have.
  void plan() {
    double moving_px = 0.0;
    const Image& image = *image_;
    for (std::size_t c = 0; c < bins_->cell_count(); ++c) {
      const Cell cell = bins_->cell(c);
      if (typical_motion(*bins_, bins_->packets(c)) > 0.0f)
        moving_px += double{1.0} * cell.width * cell.height;
      if (cell.x < image.x + image.width && cell.x + cell.width > image.x &&
          cell.y < image.y + image.height && cell.y + cell.height > image.y)
        window_cells_.push_back(c);
    }
    // What stands still has no error, so that what moves may have more.
    const double film_px = double{1.0} * scene_.film.width * scene_.film.height;
    allowed_mean_square_ = slack(moving_px / (cell_px * cell_px)) *
                           std::pow(10.0, -0.1 * options_.max_error_db) * film_px / std::max(1.0, moving_px);
  }

  CellResult render_cell(std::size_t index, SampledCell& renderer, InstantTable& table) {
    const Cell cell = bins_->cell(index);
    const std::span<const PacketRef> packets = bins_->packets(index);
    renderer.begin(cell, packets);
    const float motion = exposure_.instant() ? 0.0f : typical_motion(*bins_, packets);
    CellResult result;
    int count = motion > 0.0f ? options_.samples : 1;
    if (count == 0) count = first_instants(motion, options_.max_error_db);
    const bool adaptive = options_.samples == 0 && motion > 0.0f;
    for (int i = 0; i < count; ++i) {
      InstantWeights weights;
      if (adaptive) weights = estimating_weights(i, count);
      renderer.add(*table.at(2 * i + 1, 2 * count), weights);
    }
    result.instants = count;
    if (adaptive) {
      const double of_cell = options_.max_cell_error_db > 0.0
                                 ? std::pow(10.0, -0.1 * options_.max_cell_error_db)
                                 : std::numeric_limits<double>::infinity();
      const double allowed = std::min(allowed_mean_square_, of_cell) * 3.0 * cell.width * cell.height;
      ErrorEstimate estimate(renderer.squares(), count);
      // Doubled by the instants half-way between: with those at both ends, at half weight, the rule is the
      // trapezoid's.
      for (bool at_ends = true; estimate.squares() > allowed && count < most_chosen; at_ends = false) {
        renderer.alternate_from_sums(count);
        const int added = at_ends ? count + 1 : count;
        for (int i = 0; i < added; ++i) {
          const float w = at_ends && (i == 0 || i == count) ? 0.5f : 1.0f;
          renderer.add(at_ends ? *table.at(i, count) : *table.at(2 * i + 1, 2 * count), {w, -w, 0.0f, 0.0f});
        }
        result.instants += added;
        count *= 2;
        estimate.refine(renderer.squares(), count);
      }
      result.squares = estimate.squares();
    }
    const double weight = count;
    store(cell, renderer, weight);
    return result;
  }

  void store(const Cell& cell, SampledCell& renderer, double weight) {
    thread_local CellImage pixels;
    renderer.image(weight, pixels);
    Image& image = *image_;
    for (int y = std::max(cell.y, image.y); y < std::min(cell.y + cell.height, image.y + image.height); ++y)
      for (int x = std::max(cell.x, image.x); x < std::min(cell.x + cell.width, image.x + image.width); ++x) {
        const auto from = static_cast<std::size_t>((y - cell.y) * cell_px + (x - cell.x));
        const std::size_t to = static_cast<std::size_t>(y - image.y) * static_cast<std::size_t>(image.width) +
                               static_cast<std::size_t>(x - image.x);
        const double* rgba = &pixels.rgba[4 * from];
        const double left = std::max(0.0, 1.0 - rgba[3]);
        for (std::size_t c = 0; c < 4; ++c)
          image.rgba[4 * to + c] =
              static_cast<float>(rgba[c] + left * double{scene_.background[static_cast<int>(c)]});
        image.depth[to] = rgba[3] > 0.0 ? static_cast<float>(pixels.depth[from] / rgba[3])
                                        : std::numeric_limits<float>::infinity();
      }
  }

  void describe(const std::vector<PointPackets>& objects, const SampledCounters& total,
                const SampledMath& math, Statistics& s) const {
    double surfels = 0.0, packets = 0.0, instants = 0.0, px = 0.0, squares = 0.0, worst = 0.0;
    int most = 0;
    for (const PointPackets& object : objects) {
      surfels += static_cast<double>(object.object->cloud.size());
      packets += static_cast<double>(object.count);
    }
    for (std::size_t i = 0; i < results_.size(); ++i) {
      const Cell cell = bins_->cell(window_cells_[i]);
      const double area = double{1.0} * cell.width * cell.height;
      px += area;
      instants += area * results_[i].instants;
      most = std::max(most, results_[i].instants);
      squares += results_[i].squares;
      worst = std::max(worst, results_[i].squares / (3.0 * area));
    }
    s.count("surfels", surfels);
    s.count("packed_bytes", static_cast<double>(packed_bytes(scene_, exposure_)));
    s.count("packets", packets);
    s.count("instants", static_cast<double>(total.instants));
    s.count("instants_per_pixel", instants / std::max(1.0, px));
    s.count("most_instants", most);
    s.count("packets_seen", static_cast<double>(total.packets));
    s.count("packets_hidden", static_cast<double>(total.packets_hidden));
    s.count("discs_general", static_cast<double>(total.general_discs));
    s.count("fragments_behind", static_cast<double>(total.fragments_behind));
    if (options_.samples == 0) {
      const double rmse = std::sqrt(squares / (3.0 * std::max(1.0, px)));
      s.count("expected_rmse", rmse);
      s.count("expected_psnr_db", -20.0 * std::log10(rmse));
      s.count("expected_worst_cell_rmse", std::sqrt(worst));
    }
    s.effect(most > 1 ? "motion blur: instants averaged where something moves"
                      : "motion blur: skipped, nothing moves during the exposure");
    s.effect(std::string("arithmetic: ") + math.name);
  }

  const Scene& scene_;
  const SampledOptions& options_;
  const RenderControl& control_;
  Exposure exposure_;
  const PacketBins* bins_ = nullptr;
  Image* image_ = nullptr;
  std::vector<std::size_t> window_cells_;
  double allowed_mean_square_ = 0.0;
  std::vector<CellResult> results_;
};

}  // namespace

Status SampledOptions::validate() const {
  if (samples < 0 || samples > 1 << 20)
    return Error{"", "samples", "must be in [1, 1048576], or 0 to have them chosen"};
  if (!(max_error_db > 0.0 && max_error_db <= 150.0))
    return Error{"", "max_error_db", "must be above 0 and at most 150"};
  if (!(max_cell_error_db >= 0.0 && max_cell_error_db <= 150.0))
    return Error{"", "max_cell_error_db", "must be above 0 and at most 150, or 0 where it is not asked for"};
  if (implementation < -1) return Error{"", "implementation", "must be −1 or more"};
  return Done{};
}

Result<Rendered> render_sampled(const Scene& scene, const SampledOptions& options,
                                const RenderControl& control) {
  if (Status status = options.validate(); !status) return status.error();
  if (Status status = control.validate(); !status) return status.error();
  if (Status status = scene.validate(); !status) return status.error();
  try {
    // An arena larger than the machine gains nothing, and makes oneTBB print a warning.
    const int available = tbb::info::default_concurrency();
    tbb::task_arena arena(control.threads > 0 ? std::min(control.threads, available) : available);
    return arena.execute([&] { return Renderer(scene, options, control).render(); });
  } catch (const std::bad_alloc&) {
    return Error{"", "", "not enough memory to render the frame"};
  }
}

}  // namespace swept
