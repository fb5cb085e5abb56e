#include "abuffer/splats/splat_frame.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <tbb/task_arena.h>

#include "abuffer/lens_looks.h"
#include "abuffer/parallel.h"
#include "abuffer/splats/cell_work.h"
#include "abuffer/splats/film_motion.h"
#include "abuffer/splats/film_still.h"
#include "abuffer/splats/film_surfaces.h"
#include "abuffer/splats/share_instants.h"
#include "abuffer/splats/splat_cell.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/splats/splat_row.h"
#include "splat/motion/instant.h"
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
    if (control_.max_bytes > 0 && bytes > control_.max_bytes)
      return Error{"", "max_bytes", "splats and points alone take " + std::to_string(bytes) + " bytes",
                   ErrorKind::out_of_memory};
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
    standing_ = SplatRow(scene_, sets_, false, exposure_.open, math_, grid_, wanted_of_window());
    plan();
    out.statistics.time("motion", watch.lap());
    const auto unfinished = [](const CellWork& work) { return !work.done && !work.waiting; };
    do {
      if (!render_round()) return stopped_error();
    } while (std::any_of(cells_.begin(), cells_.end(), unfinished) || spend_more());
    parallel_for_each_index(cells_.size(), [&](std::size_t i) {
      if (cells_[i].waiting) finish(cells_[i]);
    });
    if (control_.progress && told_ < 1.0) call_back(control_.progress, 1.0);
    out.statistics.time("cells", watch.lap());
    describe(out.statistics);
    for (const CellWork& work : cells_)
      out.parts.push_back({work.cell.x, work.cell.y, work.cell.width, work.cell.height, work.instants});
    return out;
  }

 private:
  static std::size_t implementation_of(const SampledOptions& options, std::size_t count) {
    return options.implementation < 0 ? count - 1
                                      : std::min(static_cast<std::size_t>(options.implementation), count - 1);
  }

  [[nodiscard]] bool in_window(const Cell& cell) const {
    const Image& image = *image_;
    return cell.x < image.x + image.width && cell.x + cell.width > image.x &&
           cell.y < image.y + image.height && cell.y + cell.height > image.y;
  }
  [[nodiscard]] std::vector<char> wanted_of_window() const {
    std::vector<char> wanted(grid_.size());
    for (std::size_t c = 0; c < grid_.size(); ++c) wanted[c] = in_window(grid_.cell(c));
    return wanted;
  }

  void plan();
  void begin_cells();
  void begin_behind_lens();
  void allow(double mean_square);
  void forecast(const SplatRow& standing);
  void count_without_forecast(const SplatRow& standing);
  void count_what_fades();
  /// Where splats pass the near plane on the film, no more than a few hundred.
  [[nodiscard]] int instants_of_jumps(double near_jumps) const {
    constexpr double most = 257.0;
    return static_cast<int>(std::min(most, std::ceil(std::sqrt(near_jumps / allowed_mean_square_))));
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
  Scene pinhole_;                ///< where there is a lens
  int instants_of_a_point_ = 1;  ///< where its points are given
  std::vector<SplatPackets> sets_;
  SplatRow standing_;
  std::unique_ptr<FilmMotion> motion_;
  std::unique_ptr<FilmSurfaces> surfaces_;
  std::vector<CellWork> cells_;
  double allowed_mean_square_ = 0.0;
  Image* image_ = nullptr;
  PerThread<SplatPainter> painters_;
  std::size_t placed_instants_ = 0;
  Stopwatch begun_;
  double placing_seconds_ = 0.0;  ///< of a round
  std::mutex progress_mutex_;
  double drawn_ = 0.0, planned_ = 0.0, told_ = 0.0;
};

/// Which cells move, and how much error those may have.
void SplatFrame::begin_cells() {
  const bool any_moves =
      std::any_of(sets_.begin(), sets_.end(), [](const SplatPackets& set) { return set.moves; });
  if (any_moves && !exposure_.instant())
    motion_ = std::make_unique<FilmMotion>(scene_, exposure_, sets_, math_, grid_);
  double moving_px = 0.0;
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    CellWork work;
    work.index = c;
    work.cell = grid_.cell(c);
    const float surface_px = surfaces_->motion_px(c);
    const bool splats_move = motion_ != nullptr && motion_->moves(c);
    // At an instant velocities have been followed up to it.
    work.moves = exposure_.instant() ? any_moves : splats_move || surface_px > 0.0f;
    if (work.moves && !exposure_.instant()) {
      moving_px += double{1.0} * work.cell.width * work.cell.height;
      work.adaptive = options_.samples == 0;
      work.estimated = work.adaptive || options_.error_channel;
      work.count = options_.samples;
    }
    cells_.push_back(std::move(work));
  }
  // What stands still has no error, so that what moves may have more.
  const double film_px = double{1.0} * scene_.film.width * scene_.film.height;
  allow(std::pow(10.0, -0.1 * options_.max_error_db) * film_px / std::max(1.0, moving_px));
}

/// In a cell, or what cells may have at most where that is less.
void SplatFrame::allow(double mean_square) {
  allowed_mean_square_ = options_.max_cell_error_db > 0.0
                             ? std::min(mean_square, std::pow(10.0, -0.1 * options_.max_cell_error_db))
                             : mean_square;
}

/// Everything may be anywhere: each cell begins with a few looks, and doubles them.
void SplatFrame::begin_behind_lens() {
  const bool moves = std::any_of(scene_.objects.begin(), scene_.objects.end(), [&](const Object& object) {
    return !stands_still(scene_, object, exposure_);
  });
  float motion = 0.0f;
  for (std::size_t c = 0; c < grid_.size(); ++c) motion = std::max(motion, surfaces_->motion_px(c));
  int count = moves ? std::max(1, options_.samples) : 1;
  if (options_.samples == 0)
    count = std::max(count, first_instants(motion, options_.max_error_db, other_instants_per_px));
  if (lens_.given()) {
    // Of what moves a single instant for each point leaves the two too much to chance.
    if (options_.samples == 0 && moves) count = std::max(count, 2 * lens_.points());
    instants_of_a_point_ = (count + lens_.points() - 1) / lens_.points();
    count = instants_of_a_point_ * lens_.points();
  } else {
    // Of the points that a given number would be; what is soft or large needs fewer.
    constexpr int share = 16;
    int wanted = std::max(count, lens_point_count(scene_) / share);
    for (count = 16; count < wanted;) count *= 2;
  }
  for (std::size_t c = 0; c < grid_.size(); ++c) {
    CellWork work;
    work.index = c;
    work.cell = grid_.cell(c);
    work.moves = work.lens = true;
    work.adaptive = work.estimated = !lens_.given();
    work.count = count;
    cells_.push_back(std::move(work));
  }
  allow(std::pow(10.0, -0.1 * options_.max_error_db));
}

/// How many instants cells take by what a still shows, and that still as one of them.
void SplatFrame::forecast(const SplatRow& standing) {
  const std::vector<char> all(grid_.size(), 1), none(grid_.size(), 0);
  // Where what is in front in the middle is too fast for the film, another time may show what is behind.
  for (const double share : {0.5, 1.0 / 6.0}) {
    const double frame = exposure_.at(share);
    motion_->look_for_ways(scene_, sets_, frame, standing, math_, grid_);
    const FilmStill still =
        draw_still(grid_, standing, SplatRow(scene_, sets_, true, frame, math_, grid_, all), *surfaces_,
                   surfaces_->at(share, all), painters_, share == 0.5 ? wanted_of_window() : none, cells_);
    ++placed_instants_;
    const ErrorForecast errors(still, *motion_, scene_.splats.dilation_px2);
    parallel_for_each_index(cells_.size(), [&](std::size_t c) {
      CellWork& work = cells_[c];
      if (!work.adaptive || work.forecast || surfaces_->motion_px(work.index) > 0.0f) return;
      work.forecast = errors.of(work.cell, work.index, allowed_mean_square_);
      if (work.forecast) work.count = work.forecast->count;
    });
    std::size_t open = 0;
    for (const CellWork& work : cells_) open += work.adaptive && !work.forecast ? 1 : 0;
    if (4 * open <= cells_.size()) break;
  }
}

/// By how far splats move in their own standard deviations, and discs.
void SplatFrame::count_without_forecast(const SplatRow& standing) {
  if (motion_ != nullptr) motion_->look_for_spreads(scene_, exposure_, sets_, standing, math_, grid_);
  // With time to spend the first look is a coarse one.
  const double first_db = options_.max_seconds > 0.0 ? 30.0 : options_.max_error_db;
  for (CellWork& work : cells_) {
    if (!work.adaptive || work.forecast) continue;
    const bool splats_move = motion_ != nullptr && motion_->moves(work.index);
    work.count = std::max(first_instants(surfaces_->motion_px(work.index), first_db, other_instants_per_px),
                          splats_move ? first_splat_instants(motion_->spread(work.index), first_db) : 2);
    if (motion_ != nullptr)
      work.count = std::max(work.count, instants_of_jumps(motion_->near_jumps_of(work.index)));
    if (work.has_middle) work.count |= 1;
  }
}

/// No fewer than show a splat that comes and goes during the exposure: where it does is not looked for.
void SplatFrame::count_what_fades() {
  constexpr int most = 65;
  const double first_db = options_.max_seconds > 0.0 ? 30.0 : options_.max_error_db;
  const int least = std::min(most, first_splat_instants(motion_->briefest(), first_db));
  for (CellWork& work : cells_) {
    if (!work.adaptive || !motion_->moves(work.index)) continue;
    work.count = std::max(work.count, least);
    if (work.has_middle) work.count |= 1;
  }
}

/// How many instants each cell begins with.
void SplatFrame::plan() {
  lens_.any() ? begin_behind_lens() : begin_cells();
  if (options_.samples == 0 && !exposure_.instant() && !lens_.any()) {
    const SplatRow standing(scene_, sets_, false, exposure_.open, math_, grid_,
                            std::vector<char>(grid_.size(), 1));
    if (motion_ != nullptr && options_.max_seconds == 0.0) forecast(standing);
    if (std::any_of(cells_.begin(), cells_.end(),
                    [](const CellWork& work) { return work.adaptive && !work.forecast; }))
      count_without_forecast(standing);
    if (motion_ != nullptr && motion_->briefest() > 0.0f) count_what_fades();
  }
  std::size_t splats = 0;
  for (const SplatPackets& set : sets_) splats += set.moves ? set.splats : 0;
  share_instants(cells_, splats);
  for (CellWork& work : cells_)
    if (work.has_middle && work.estimated) work.sums->weigh(work.weights(work.count / 2));
  // What is decided for a cell depends on the whole film, and not on what else is asked for.
  std::erase_if(cells_, [&](const CellWork& work) { return !in_window(work.cell); });
  for (const CellWork& work : cells_) planned_ += work.count;
}

/// Draws what every cell still lacks. False: the render was stopped.
bool SplatFrame::render_round() {
  placing_seconds_ = 0.0;
  std::vector<RoundInstant> instants;
  for (CellWork& work : cells_) {
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
  std::size_t splats = 0;
  for (const SplatPackets& set : sets_) splats += set.moves ? set.splats : 0;
  const std::size_t an_instant = sizeof(PlacedSplat) * splats + surfaces_->instant_bytes();
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
  for (const CellWork& work : cells_) {
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
  objects.back() = surfaces_->at(0.5, wanted_of_window());
  Stopwatch placing;
  parallel_for_each_index(instants.size(), [&](std::size_t k) {
    if (control_.stop.stop_requested()) return;
    if (lens_.any()) {
      const LensLook look = lens_.at(instants[k].numerator, instants_of_a_point_);
      Scene pinhole = pinhole_;
      pinhole.camera.lens_point = look.point;
      objects[k] = surfaces_->at(look.share, wanted[k], &pinhole);
      rows[k] = SplatRow(pinhole, sets_, true, exposure_.at(look.share), math_, grid_, wanted[k]);
      return;
    }
    objects[k] = surfaces_->at(instants[k].time(), wanted[k]);
    rows[k] = SplatRow(scene_, sets_, true, exposure_.at(instants[k].time()), math_, grid_, wanted[k]);
  });
  placed_instants_ += instants.size();
  placing_seconds_ += placing.lap();
  static const SplatRow nothing;
  static const std::vector<SampledCell::Surface> no_surfaces;
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, cells_.size(), 1), [&](const auto& range) {
    SplatPainter& painter = painters_.local();
    for (std::size_t c = range.begin(); c != range.end(); ++c) {
      CellWork& work = cells_[c];
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
    work.judge(motion_ != nullptr ? motion_->near_jumps_of(work.index) : 0.0);
  }
  if (!work.adaptive) return finish(work);
  if (options_.max_seconds > 0.0) {
    work.waiting = true;
    return;
  }
  const double allowed = allowed_mean_square_ * 3.0 * work.cell.width * work.cell.height;
  if (work.expected_squares <= allowed || work.count >= most_chosen_instants)
    finish(work);
  else
    work.double_instants();
}

/// Doubles those that wait and gain most by it, as far as the seconds asked for go. False: none.
bool SplatFrame::spend_more() {
  if (!(options_.max_seconds > 0.0)) return false;
  double best = 0.0;
  for (const CellWork& work : cells_) best = std::max(best, work.gain());
  if (best == 0.0) return false;
  std::vector<CellWork*> order;
  // A doubling divides the gain by eight or more: a round takes what is within that of the best.
  for (CellWork& work : cells_)
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
  double splats = 0.0, moving = 0.0, instants = 0.0, px = 0.0, squares = 0.0, worst = 0.0, looks = 0.0;
  int most = 0;
  for (const SplatPackets& set : sets_) {
    splats += static_cast<double>(set.splats);
    moving += set.moves ? static_cast<double>(set.splats) : 0.0;
  }
  for (const CellWork& work : cells_) {
    const double area = double{1.0} * work.cell.width * work.cell.height;
    px += area;
    instants += area * work.instants;
    most = std::max(most, work.instants);
    squares += work.expected_squares;
    worst = std::max(worst, work.expected_squares / (3.0 * area));
  }
  for (const SplatPainter& painter : painters_) looks += static_cast<double>(painter.looks);
  s.count("splats", splats);
  s.count("splats_moving", moving);
  s.count("surfels", static_cast<double>(surfaces_->discs()));
  s.count("triangles", static_cast<double>(surfaces_->triangles()));
  s.count("packed_bytes", static_cast<double>(packed_splat_bytes(scene_)));
  s.count("instants_placed", static_cast<double>(placed_instants_));
  s.count("instants_per_pixel", instants / std::max(1.0, px));
  s.count("most_instants", most);
  s.count("blocks_drawn", looks);
  if (motion_ != nullptr) {
    s.count("fastest_splat_px", double{motion_->fastest_px()});
    s.count("fastest_splat_deviations", double{motion_->fastest_spread()});
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
