#include "abuffer/splats/splat_frame.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>

#include "abuffer/lens_looks.h"
#include "abuffer/parallel.h"
#include "abuffer/render_valid.h"
#include "abuffer/resolve/cell_image.h"
#include "abuffer/splats/cell_work.h"
#include "abuffer/splats/film_surfaces.h"
#include "abuffer/splats/splat_cell.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/splats/splat_plan.h"
#include "abuffer/splats/splat_row.h"
#include "splat/stopwatch.h"

namespace swept {
namespace {

/// Placed splats of so many bytes are held at once, or those of one instant.
constexpr std::size_t most_placed_bytes = std::size_t{256} << 20;

class SplatFrame {
 public:
  SplatFrame(const Scene& scene, const SampledOptions& options, const RenderControl& control)
      : scene_(scene),
        options_(options),
        control_(control),
        exposure_(scene.exposure()),
        grid_(scene.film),
        math_(splat_maths().first[implementation_of(options, splat_maths().count)]),
        rule_(splat_rule(scene)),
        lens_(scene, options.samples),
        pinhole_(lens_.any() ? pinhole_of(scene) : Scene()),
        painters_([this] { return SplatPainter(math_, rule_); }) {}

  Result<Rendered> render() {
    if (Status status = check_lens(lens_, options_); !status) return status.error();
    const std::size_t bytes = packed_splat_bytes(scene_) + packed_bytes(scene_, exposure_);
    if (Status fits = check_bytes(bytes, control_, "splats and points"); !fits) return fits.error();
    Stopwatch watch;
    Rendered out;
    sets_ = pack_splats(scene_, exposure_, options_.only_standing);
    out.image = blank_image(scene_.film);
    image_ = &out.image;
    const std::size_t which = implementation_of(options_, sampled_maths().count);
    surfaces_ =
        std::make_unique<FilmSurfaces>(scene_, exposure_, options_.only_standing,
                                       sampled_maths().first[which], mesh_maths().first[which], grid_);
    out.statistics.time("packets", watch.lap());
    if (options_.error_channel)
      out.image.channels.push_back({"error", std::vector<float>(out.image.pixel_count())});
    for (std::size_t c = 0; c < grid_.size(); ++c) window_.push_back(in_window(grid_.cell(c), out.image));
    standing_ = SplatRow(scene_, sets_, false, exposure_.open, math_, grid_, window_);
    plan_ = plan_splats(
        {scene_, options_, exposure_, grid_, math_, lens_, sets_, *surfaces_, painters_, window_});
    for (const CellWork& work : plan_.cells) planned_ += work.count;
    out.statistics.time("motion", watch.lap());
    const auto unfinished = [](const CellWork& work) { return !work.done && !work.waiting; };
    do {
      if (!render_round()) return stopped_error();
    } while (std::any_of(plan_.cells.begin(), plan_.cells.end(), unfinished) || spend_more());
    parallel_for_each_index(plan_.cells.size(), [&](std::size_t i) {
      if (plan_.cells[i].waiting) finish(plan_.cells[i]);
    });
    if (control_.progress && told_ < 1.0) call_back(control_.progress, 1.0);
    out.statistics.time("cells", watch.lap());
    describe(out.statistics);
    for (const CellWork& work : plan_.cells)
      out.parts.push_back({work.cell.x, work.cell.y, work.cell.width, work.cell.height, work.instants});
    return out;
  }

 private:
  static std::size_t implementation_of(const SampledOptions& options, std::size_t count) {
    return options.implementation < 0 ? count - 1
                                      : std::min(static_cast<std::size_t>(options.implementation), count - 1);
  }

  [[nodiscard]] bool render_round();
  [[nodiscard]] bool render_batch(std::span<const RoundInstant> instants);
  void finish_round(CellWork& work);
  void finish(CellWork& work);
  [[nodiscard]] bool spend_more();
  void tell(double more);
  void describe(Statistics& statistics) const;

  const Scene& scene_;
  const SampledOptions& options_;
  const RenderControl& control_;
  Exposure exposure_;
  CellGrid grid_;
  const SplatMath& math_;
  SplatRule rule_;
  LensLooks lens_;
  Scene pinhole_;  ///< where there is a lens
  std::vector<SplatPackets> sets_;
  SplatRow standing_;
  std::unique_ptr<FilmSurfaces> surfaces_;
  std::vector<char> window_;  ///< of every cell of the grid: whether any of it is asked for
  SplatPlan plan_;
  Image* image_ = nullptr;
  PerThread<SplatPainter> painters_;
  Stopwatch begun_;
  double placing_seconds_ = 0.0;  ///< of a round
  std::mutex progress_mutex_;
  double drawn_ = 0.0, planned_ = 0.0, told_ = 0.0;
};

/// Draws what every cell still lacks. False: the render was stopped.
bool SplatFrame::render_round() {
  placing_seconds_ = 0.0;
  std::vector<RoundInstant> instants;
  for (CellWork& work : plan_.cells) {
    work.next = 0;
    if (!work.waiting) work.seconds = 0.0;
    if (!work.moves) continue;
    for (int i = 0; i < work.round_size(); ++i)
      if (!work.has(i)) instants.push_back(work.instant(i));
    // A few numbers of instants are what all cells have between them.
    if (instants.size() > 1u << 16) {
      std::sort(instants.begin(), instants.end());
      instants.erase(std::unique(instants.begin(), instants.end()), instants.end());
    }
  }
  std::sort(instants.begin(), instants.end());
  instants.erase(std::unique(instants.begin(), instants.end()), instants.end());
  const std::size_t an_instant = sizeof(PlacedSplat) * moving_splats(sets_) + surfaces_->instant_bytes();
  const std::size_t batch =
      std::max<std::size_t>(1, most_placed_bytes / std::max<std::size_t>(1, an_instant));
  for (std::size_t begin = 0; begin < std::max<std::size_t>(1, instants.size()); begin += batch) {
    const std::size_t size = std::min(batch, instants.size() - std::min(begin, instants.size()));
    if (!render_batch(std::span(instants).subspan(std::min(begin, instants.size()), size))) return false;
  }
  return true;
}

bool SplatFrame::render_batch(std::span<const RoundInstant> instants) {
  std::vector<std::vector<char>> wanted(instants.size(), std::vector<char>(grid_.size(), 0));
  for (const CellWork& work : plan_.cells) {
    if (!work.moves) continue;
    for (int i = work.next; i < work.round_size(); ++i) {
      if (work.has(i)) continue;
      const auto found = std::lower_bound(instants.begin(), instants.end(), work.instant(i));
      if (found == instants.end()) break;
      if (*found == work.instant(i))
        wanted[static_cast<std::size_t>(found - instants.begin())][work.index] = 1;
    }
  }
  std::vector<SplatRow> rows(instants.size());
  // One more, of cells in which nothing moves.
  std::vector<FilmSurfaces::Instant> objects(instants.size() + 1);
  objects.back() = surfaces_->at(0.5, window_);
  Stopwatch placing;
  parallel_for_each_index(instants.size(), [&](std::size_t k) {
    if (control_.stop.stop_requested()) return;
    if (lens_.any()) {
      const LensLook look = lens_.at(instants[k].numerator, plan_.instants_of_a_point);
      Scene pinhole = pinhole_;
      pinhole.camera.lens_point = look.point;
      objects[k] = surfaces_->at(look.share, wanted[k], &pinhole);
      rows[k] = SplatRow(pinhole, sets_, true, exposure_.at(look.share), math_, grid_, wanted[k]);
      return;
    }
    objects[k] = surfaces_->at(instants[k].time(), wanted[k]);
    rows[k] = SplatRow(scene_, sets_, true, exposure_.at(instants[k].time()), math_, grid_, wanted[k]);
  });
  plan_.placed_instants += instants.size();
  placing_seconds_ += placing.lap();
  static const SplatRow nothing;
  static const std::vector<SampledCell::Surface> no_surfaces;
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, plan_.cells.size(), 1), [&](const auto& range) {
    SplatPainter& painter = painters_.local();
    for (std::size_t c = range.begin(); c != range.end(); ++c) {
      CellWork& work = plan_.cells[c];
      if (work.done || work.waiting || control_.stop.stop_requested()) continue;
      if (!work.sums) work.sums = std::make_unique<CellOfSplats>();
      Stopwatch own;
      FilmSurfaces::OfCell* const surfaces = surfaces_->empty() ? nullptr : &surfaces_->begin(work.index);
      int drawn = 0;
      while (work.next < work.round_size()) {
        if (work.has(work.next)) {
          ++work.next;
          continue;
        }
        std::size_t k = instants.size();
        if (work.moves) {
          const auto found = std::lower_bound(instants.begin(), instants.end(), work.instant(work.next));
          if (found == instants.end() || !(*found == work.instant(work.next))) break;
          k = static_cast<std::size_t>(found - instants.begin());
        }
        painter.add(work.cell, work.index, standing_, k < rows.size() ? rows[k] : nothing,
                    surfaces != nullptr ? surfaces->at(objects[k]) : no_surfaces, work.weights(work.next),
                    *work.sums);
        ++work.next, ++drawn;
      }
      work.seconds += own.lap();
      work.instants += drawn;
      if (work.next == work.round_size()) finish_round(work);
      if (control_.progress) tell(drawn);
    }
  });
  return !control_.stop.stop_requested();
}

/// Into the image.
void SplatFrame::finish(CellWork& work) {
  work.sums->store(work.cell, work.count, scene_.background[3], *image_);
  if (options_.error_channel && work.estimate)
    work.sums->store_error(work.cell, work.estimate->per_alternating(), *image_,
                           image_->channels.front().values);
  work.sums.reset();
  work.estimate.reset();
  work.done = true;
  work.waiting = false;
}

/// Stores a cell that is good enough, and doubles one that is not.
void SplatFrame::finish_round(CellWork& work) {
  if (work.estimated && work.count > 1) {
    work.judge(plan_.motion != nullptr ? plan_.motion->near_jumps_of(work.index) : 0.0);
  }
  if (!work.adaptive) return finish(work);
  if (options_.max_seconds > 0.0) {
    work.waiting = true;
    return;
  }
  const double allowed = plan_.allowed_mean_square * 3.0 * work.cell.width * work.cell.height;
  if (work.expected_squares <= allowed || work.count >= most_chosen_instants)
    finish(work);
  else
    work.double_instants();
}

/// Doubles those that wait and gain most by it, as far as the seconds asked for go. False: none.
bool SplatFrame::spend_more() {
  if (!(options_.max_seconds > 0.0)) return false;
  double best = 0.0;
  for (const CellWork& work : plan_.cells) best = std::max(best, work.gain());
  if (best == 0.0) return false;
  std::vector<CellWork*> order;
  // A doubling divides the gain by eight or more: a round takes what is within that of the best.
  for (CellWork& work : plan_.cells)
    if (work.gain() >= 0.125 * best) order.push_back(&work);
  std::stable_sort(order.begin(), order.end(),
                   [](const CellWork* a, const CellWork* b) { return a->gain() > b->gain(); });
  const auto threads = static_cast<double>(tbb::this_task_arena::max_concurrency());
  double left = (options_.max_seconds - begun_.so_far() - 2.0 * placing_seconds_) * threads;
  bool any = false;
  for (CellWork* work : order) {
    const double needs = work->seconds * (work->doublings == 0 ? 1.0 : 2.0);
    if (needs > left) break;
    left -= needs;
    work->double_instants();
    any = true;
  }
  return any;
}

void SplatFrame::tell(double more) {
  const std::lock_guard lock(progress_mutex_);
  drawn_ += more;
  // Cells that are doubled add to what was planned.
  const double share = options_.max_seconds > 0.0 ? std::min(0.99, begun_.so_far() / options_.max_seconds)
                                                  : std::min(1.0, drawn_ / std::max(1.0, planned_));
  if (share > told_) call_back(control_.progress, told_ = share);
}

void SplatFrame::describe(Statistics& s) const {
  double splats = 0.0, instants = 0.0, px = 0.0, squares = 0.0, worst = 0.0, looks = 0.0;
  int most = 0;
  for (const SplatPackets& set : sets_) splats += static_cast<double>(set.splats);
  for (const CellWork& work : plan_.cells) {
    const double area = double{1.0} * work.cell.width * work.cell.height;
    px += area;
    instants += area * work.instants;
    most = std::max(most, work.instants);
    squares += work.expected_squares;
    worst = std::max(worst, work.expected_squares / (3.0 * area));
  }
  for (const SplatPainter& painter : painters_) looks += static_cast<double>(painter.looks);
  s.count("splats", splats);
  s.count("splats_moving", static_cast<double>(moving_splats(sets_)));
  s.count("surfels", static_cast<double>(surfaces_->discs()));
  s.count("triangles", static_cast<double>(surfaces_->triangles()));
  s.count("packed_bytes", static_cast<double>(packed_splat_bytes(scene_)));
  s.count("instants_placed", static_cast<double>(plan_.placed_instants));
  s.count("instants_per_pixel", instants / std::max(1.0, px));
  s.count("most_instants", most);
  s.count("blocks_drawn", looks);
  if (plan_.motion != nullptr) {
    s.count("fastest_splat_px", double{plan_.motion->fastest_px()});
    s.count("fastest_splat_deviations", double{plan_.motion->fastest_spread()});
  }
  if (lens_.any()) describe_lens(lens_, most, s);
  if (!lens_.given() && (options_.samples == 0 || options_.error_channel))
    count_expected_error(squares, px, worst, s);
  s.effect(most > 1 ? "motion blur: instants averaged where something moves"
                    : "motion blur: skipped, nothing moves during the exposure");
  if (splats > 0.0)
    s.effect(rule_.linear ? "splats blended in linear light" : "splats blended in values of sRGB");
  s.effect(std::string("arithmetic: ") + math_.name);
}

}  // namespace

Result<Rendered> render_splats(const Scene& scene, const SampledOptions& options,
                               const RenderControl& control) {
  return SplatFrame(scene, options, control).render();
}

}  // namespace swept
