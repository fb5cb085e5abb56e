#include "abuffer/splats/splat_frame.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <numeric>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <tbb/enumerable_thread_specific.h>

#include "abuffer/parallel.h"
#include "abuffer/resolve/sample_plan.h"
#include "abuffer/splats/splat_cell.h"
#include "abuffer/splats/splat_estimate.h"
#include "abuffer/splats/film_motion.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/splats/splat_row.h"
#include "abuffer/splats/splat_surfaces.h"
#include "splat/stopwatch.h"

namespace swept {
namespace {

/// Placed splats of so many bytes are held at once, or those of one instant.
constexpr std::size_t most_placed_bytes = std::size_t{256} << 20;

/// Instants are doubled at most to so many.
constexpr int most_chosen = 1 << 14;

/// Shutter time numerator / denominator.
struct RoundInstant {
  int numerator, denominator;

  [[nodiscard]] double time() const { return static_cast<double>(numerator) / denominator; }
  [[nodiscard]] bool operator<(const RoundInstant& other) const {
    return std::int64_t{numerator} * other.denominator < std::int64_t{other.numerator} * denominator;
  }
  [[nodiscard]] bool operator==(const RoundInstant& other) const {
    return !(*this < other) && !(other < *this);
  }
};

/// A cell of the film's window on its way to the image. Its instants are N midpoints of strata of the
/// exposure; doubled, those half-way between and at both ends too, at half weight there: the trapezoid's
/// rule; doubled again, those half-way between.
struct CellWork {
  std::size_t index = 0;  ///< in the grid
  Cell cell;
  int count = 1;  ///< of the rule, after this round
  bool moves = false, adaptive = false, done = false;
  int doublings = 0;
  int instants = 0;  ///< looked at in all
  int next = 0;      ///< of this round
  double expected_squares = 0.0;
  std::unique_ptr<CellOfSplats> sums;  ///< while it is not done
  std::unique_ptr<SplatEstimate> estimate;

  [[nodiscard]] int round_size() const {
    return done ? 0 : doublings == 0 ? count : doublings == 1 ? count / 2 + 1 : count / 2;
  }
  /// In the order of time.
  [[nodiscard]] RoundInstant instant(int i) const {
    if (doublings == 0) return {2 * i + 1, 2 * count};
    return doublings == 1 ? RoundInstant{i, count / 2} : RoundInstant{2 * i + 1, count};
  }
  [[nodiscard]] InstantWeights weights(int i) const {
    if (!adaptive) return {};
    if (doublings == 0) return estimating_weights(i, count);
    const float w = doublings == 1 && (i == 0 || i == count / 2) ? 0.5f : 1.0f;
    return {w, -w, 0.0f, 0.0f};
  }
};

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
        painters_([this] { return SplatPainter(math_, rule_); }) {}

  Result<Rendered> render() {
    const std::size_t bytes = packed_splat_bytes(scene_) + packed_bytes(scene_, exposure_);
    if (control_.max_bytes > 0 && bytes > control_.max_bytes)
      return Error{"", "max_bytes", "splats and points alone take " + std::to_string(bytes) + " bytes"};
    Stopwatch watch;
    Rendered out;
    sets_ = pack_splats(scene_, exposure_, options_.only_standing);
    surfaces_ = std::make_unique<SplatSurfaces>(scene_, exposure_, options_.only_standing,
                                                implementation_of(options_, sampled_maths().count));
    out.statistics.time("packets", watch.lap());
    out.image = blank_image(scene_.film);
    image_ = &out.image;
    standing_ = SplatRow(scene_, sets_, false, exposure_.open, math_, grid_, wanted_of_window());
    plan();
    out.statistics.time("motion", watch.lap());
    while (std::any_of(cells_.begin(), cells_.end(), [](const CellWork& work) { return !work.done; })) {
      if (!render_round()) return Error{"", "", "the render was stopped"};
    }
    if (control_.progress && told_ < 1.0) control_.progress(1.0);
    out.statistics.time("cells", watch.lap());
    describe(out.statistics);
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
  void share_instants(int most);
  [[nodiscard]] bool render_round();
  [[nodiscard]] bool render_batch(std::span<const RoundInstant> instants);
  void finish_round(CellWork& work);
  void tell(double more);
  void describe(Statistics& statistics) const;

  const Scene& scene_;
  const SampledOptions& options_;
  const RenderControl& control_;
  Exposure exposure_;
  CellGrid grid_;
  const SplatMath& math_;
  SplatRule rule_;
  std::vector<SplatPackets> sets_;
  SplatRow standing_;
  std::unique_ptr<FilmMotion> motion_;
  std::unique_ptr<SplatSurfaces> surfaces_;
  std::vector<CellWork> cells_;
  double allowed_mean_square_ = 0.0;
  Image* image_ = nullptr;
  tbb::enumerable_thread_specific<SplatPainter> painters_;
  std::size_t placed_instants_ = 0;
  std::mutex progress_mutex_;
  double drawn_ = 0.0, planned_ = 0.0, told_ = 0.0;
};

/// How many instants each cell begins with, and how much error those that move may have.
void SplatFrame::plan() {
  const bool any_moves =
      std::any_of(sets_.begin(), sets_.end(), [](const SplatPackets& set) { return set.moves; });
  if (any_moves && !exposure_.instant())
    motion_ = std::make_unique<FilmMotion>(scene_, exposure_, sets_, standing_, math_, grid_);
  double moving_px = 0.0;
  int most = 1;
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
      work.count = options_.samples;
      if (work.adaptive)
        work.count =
            std::max(first_instants(surface_px, options_.max_error_db),
                     splats_move ? first_splat_instants(motion_->spread(c), options_.max_error_db) : 2);
      most = std::max(most, work.count);
    }
    if (in_window(work.cell)) cells_.push_back(std::move(work));
  }
  share_instants(most);
  for (const CellWork& work : cells_) planned_ += work.count;
  // What stands still has no error, so that what moves may have more.
  const double film_px = double{1.0} * scene_.film.width * scene_.film.height;
  allowed_mean_square_ = std::pow(10.0, -0.1 * options_.max_error_db) * film_px / std::max(1.0, moving_px);
  // A jump is off by up to 3 times its mean square, and where all pixels jump at once they do not make up for
  // each other.
  if (motion_ != nullptr && motion_->jumps()) allowed_mean_square_ /= 3.0;
}

/// Cells that have a half, a quarter, … of the largest number of instants need fewer of them in all than
/// cells that have as few as they can; but then some look at more. Whichever costs less.
void SplatFrame::share_instants(int most) {
  // Of placing a splat, and of drawing a pixel, in the mean over trained files: their ratio is what counts.
  constexpr double place = 0.1, draw = 0.12;
  double splats = 0.0;
  for (const SplatPackets& set : sets_) splats += set.moves ? static_cast<double>(set.splats) : 0.0;
  const auto half_of_most = [&](const CellWork& work) {
    int count = most;
    while (count % 2 == 0 && count / 2 >= std::max(2, work.count)) count /= 2;
    return count;
  };
  const auto cost = [&](const auto& count_of) {
    std::set<int> counts;
    double px = 0.0;
    for (const CellWork& work : cells_) {
      if (!work.adaptive) continue;
      counts.insert(count_of(work));
      px += double{1.0} * count_of(work) * work.cell.width * work.cell.height;
    }
    return place * splats * std::accumulate(counts.begin(), counts.end(), 0.0) + draw * px;
  };
  const bool halves = cost(half_of_most) < cost([](const CellWork& work) { return work.count; });
  for (CellWork& work : cells_)
    if (work.adaptive && halves) work.count = half_of_most(work);
}

/// Draws what every cell still lacks. False: the render was stopped.
bool SplatFrame::render_round() {
  std::vector<RoundInstant> instants;
  for (CellWork& work : cells_) {
    work.next = 0;
    if (!work.moves) continue;
    for (int i = 0; i < work.round_size(); ++i) instants.push_back(work.instant(i));
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
  const std::size_t batch =
      std::max<std::size_t>(1, most_placed_bytes / (sizeof(PlacedSplat) * std::max<std::size_t>(1, splats)));
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
      const auto found = std::lower_bound(instants.begin(), instants.end(), work.instant(i));
      if (found == instants.end()) break;
      if (*found == work.instant(i))
        wanted[static_cast<std::size_t>(found - instants.begin())][work.index] = 1;
    }
  }
  std::vector<SplatRow> rows(instants.size());
  // One more, of cells in which nothing moves.
  std::vector<std::vector<ObjectInstant>> objects(instants.size() + 1);
  objects.back() = surfaces_->at(0.5);
  parallel_for_each_index(instants.size(), [&](std::size_t k) {
    if (control_.stop.stop_requested()) return;
    objects[k] = surfaces_->at(instants[k].time());
    rows[k] = SplatRow(scene_, sets_, true, exposure_.at(instants[k].time()), math_, grid_, wanted[k]);
  });
  placed_instants_ += instants.size();
  static const SplatRow nothing;
  static const std::vector<SampledCell::Surface> no_surfaces;
  parallel_for_parts(tbb::blocked_range<std::size_t>(0, cells_.size(), 1), [&](const auto& range) {
    SplatPainter& painter = painters_.local();
    for (std::size_t c = range.begin(); c != range.end(); ++c) {
      CellWork& work = cells_[c];
      if (work.done || control_.stop.stop_requested()) continue;
      if (!work.sums) work.sums = std::make_unique<CellOfSplats>();
      SampledCell* const discs = surfaces_->begin(work.index);
      const int first = work.next;
      while (work.next < work.round_size()) {
        std::size_t k = instants.size();
        if (work.moves) {
          const auto found = std::lower_bound(instants.begin(), instants.end(), work.instant(work.next));
          if (found == instants.end() || !(*found == work.instant(work.next))) break;
          k = static_cast<std::size_t>(found - instants.begin());
        }
        painter.add(work.cell, work.index, standing_, k < rows.size() ? rows[k] : nothing,
                    discs != nullptr ? discs->surfaces(objects[k]) : no_surfaces, work.weights(work.next),
                    *work.sums);
        ++work.next;
      }
      work.instants += work.next - first;
      const double drawn = work.next - first;
      if (work.next == work.round_size()) finish_round(work);
      if (control_.progress) tell(drawn);
    }
  });
  return !control_.stop.stop_requested();
}

/// Stores a cell that is good enough, and doubles one that is not.
void SplatFrame::finish_round(CellWork& work) {
  bool enough = true;
  if (work.adaptive) {
    const SplatSquares squares = work.sums->squares(work.cell);
    if (work.estimate == nullptr)
      work.estimate = std::make_unique<SplatEstimate>(squares, work.count);
    else
      work.estimate->refine(squares, work.count);
    work.expected_squares = work.estimate->squares();
    const double of_cell = options_.max_cell_error_db > 0.0
                               ? std::pow(10.0, -0.1 * options_.max_cell_error_db)
                               : std::numeric_limits<double>::infinity();
    const double allowed = std::min(allowed_mean_square_, of_cell) * 3.0 * work.cell.width * work.cell.height;
    enough = work.expected_squares <= allowed || work.count >= most_chosen;
  }
  if (enough) {
    work.sums->store(work.cell, work.count, scene_.background[3], *image_);
    work.sums.reset();
    work.estimate.reset();
    work.done = true;
    return;
  }
  work.sums->alternate_from_sums();
  work.count *= 2;
  ++work.doublings;
}

void SplatFrame::tell(double more) {
  const std::lock_guard lock(progress_mutex_);
  drawn_ += more;
  // Cells that are doubled add to what was planned.
  const double share = std::min(1.0, drawn_ / std::max(1.0, planned_));
  if (share > told_) control_.progress(told_ = share);
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
  s.count("packed_bytes", static_cast<double>(packed_splat_bytes(scene_)));
  s.count("instants_placed", static_cast<double>(placed_instants_));
  s.count("instants_per_pixel", instants / std::max(1.0, px));
  s.count("most_instants", most);
  s.count("blocks_drawn", looks);
  if (motion_ != nullptr) {
    s.count("fastest_splat_px", double{motion_->fastest_px()});
    s.count("fastest_splat_deviations", double{motion_->fastest_spread()});
  }
  if (options_.samples == 0) {
    const double rmse = std::sqrt(squares / (3.0 * std::max(1.0, px)));
    s.count("expected_rmse", rmse);
    s.count("expected_psnr_db", -20.0 * std::log10(rmse));
    s.count("expected_worst_cell_rmse", std::sqrt(worst));
  }
  s.effect(most > 1 ? "motion blur: instants averaged where something moves"
                    : "motion blur: skipped, nothing moves during the exposure");
  s.effect(rule_.linear ? "splats blended in linear light" : "splats blended in values of sRGB");
  s.effect(std::string("arithmetic: ") + math_.name);
}

}  // namespace

Status check_splats(const Scene& scene) {
  const Object* first = nullptr;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Object& object = scene.objects[i];
    const std::string field = "/objects/" + std::to_string(i);
    if (object.splats.size() == 0) continue;
    if (first != nullptr && scene.splats.blending == SplatBlending::file &&
        first->splats.colors != object.splats.colors)
      return Error{"", field,
                   "is blended in other values than another object's splats; say in which with "
                   "/splats/blending"};
    first = &object;
  }
  return Done{};
}

Result<Rendered> render_splats(const Scene& scene, const SampledOptions& options,
                               const RenderControl& control) {
  return SplatFrame(scene, options, control).render();
}

}  // namespace swept
