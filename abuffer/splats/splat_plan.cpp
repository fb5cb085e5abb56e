#include "abuffer/splats/splat_plan.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "abuffer/resolve/sample_plan.h"
#include "abuffer/splats/film_still.h"
#include "abuffer/splats/share_instants.h"
#include "splat/motion/instant.h"

namespace swept {
namespace {

class Planner {
 public:
  explicit Planner(const SplatFilm& film) : film_(film) {}

  [[nodiscard]] SplatPlan plan();

 private:
  void begin_cells();
  void begin_behind_lens();
  void allow(double mean_square);
  void forecast(const SplatRow& standing);
  void count_without_forecast(const SplatRow& standing);
  void count_what_fades();
  /// Where splats pass the near plane on the film, no more than a few hundred.
  [[nodiscard]] int instants_of_jumps(double near_jumps) const {
    constexpr double most = 257.0;
    return static_cast<int>(std::min(most, std::ceil(std::sqrt(near_jumps / plan_.allowed_mean_square))));
  }

  const SplatFilm& film_;
  SplatPlan plan_;
};

/// Which cells move, and how much error those may have.
void Planner::begin_cells() {
  const bool any_moves =
      std::any_of(film_.sets.begin(), film_.sets.end(), [](const SplatPackets& set) { return set.moves; });
  if (any_moves && !film_.exposure.instant())
    plan_.motion =
        std::make_unique<FilmMotion>(film_.scene, film_.exposure, film_.sets, film_.math, film_.grid);
  double moving_px = 0.0;
  for (std::size_t c = 0; c < film_.grid.size(); ++c) {
    CellWork work;
    work.index = c;
    work.cell = film_.grid.cell(c);
    const float surface_px = film_.surfaces.motion_px(c);
    const bool splats_move = plan_.motion != nullptr && plan_.motion->moves(c);
    // At an instant velocities have been followed up to it.
    work.moves = film_.exposure.instant() ? any_moves : splats_move || surface_px > 0.0f;
    if (work.moves && !film_.exposure.instant()) {
      moving_px += double{1.0} * work.cell.width * work.cell.height;
      work.adaptive = film_.options.samples == 0;
      work.estimated = work.adaptive || film_.options.error_channel;
      work.count = film_.options.samples;
    }
    plan_.cells.push_back(std::move(work));
  }
  // What stands still has no error, so that what moves may have more.
  const double film_px = double{1.0} * film_.scene.film.width * film_.scene.film.height;
  allow(std::pow(10.0, -0.1 * film_.options.max_error_db) * film_px / std::max(1.0, moving_px));
}

/// In a cell, or what cells may have at most where that is less.
void Planner::allow(double mean_square) {
  plan_.allowed_mean_square =
      film_.options.max_cell_error_db > 0.0
          ? std::min(mean_square, std::pow(10.0, -0.1 * film_.options.max_cell_error_db))
          : mean_square;
}

/// Everything may be anywhere: each cell begins with a few looks, and doubles them.
void Planner::begin_behind_lens() {
  const bool moves =
      std::any_of(film_.scene.objects.begin(), film_.scene.objects.end(),
                  [&](const Object& object) { return !stands_still(film_.scene, object, film_.exposure); });
  float motion = 0.0f;
  for (std::size_t c = 0; c < film_.grid.size(); ++c) motion = std::max(motion, film_.surfaces.motion_px(c));
  int count = moves ? std::max(1, film_.options.samples) : 1;
  if (film_.options.samples == 0)
    count = std::max(count, first_instants(motion, film_.options.max_error_db, other_instants_per_px));
  if (film_.lens.given()) {
    // Of what moves a single instant for each point leaves the two too much to chance.
    if (film_.options.samples == 0 && moves) count = std::max(count, 2 * film_.lens.points());
    plan_.instants_of_a_point = (count + film_.lens.points() - 1) / film_.lens.points();
    count = plan_.instants_of_a_point * film_.lens.points();
  } else {
    // Of the points that a given number would be; what is soft or large needs fewer.
    constexpr int share = 16;
    int wanted = std::max(count, lens_point_count(film_.scene) / share);
    for (count = 16; count < wanted;) count *= 2;
  }
  for (std::size_t c = 0; c < film_.grid.size(); ++c) {
    CellWork work;
    work.index = c;
    work.cell = film_.grid.cell(c);
    work.moves = work.lens = true;
    work.adaptive = work.estimated = !film_.lens.given();
    work.count = count;
    plan_.cells.push_back(std::move(work));
  }
  allow(std::pow(10.0, -0.1 * film_.options.max_error_db));
}

/// How many instants cells take by what a still shows, and that still as one of them.
void Planner::forecast(const SplatRow& standing) {
  const std::vector<char> all(film_.grid.size(), 1), none(film_.grid.size(), 0);
  // Where what is in front in the middle is too fast for the film, another time may show what is behind.
  for (const double share : {0.5, 1.0 / 6.0}) {
    const double frame = film_.exposure.at(share);
    plan_.motion->look_for_ways(film_.scene, film_.sets, frame, standing, film_.math, film_.grid);
    const FilmStill still = draw_still(
        film_.grid, standing, SplatRow(film_.scene, film_.sets, true, frame, film_.math, film_.grid, all),
        film_.surfaces, film_.surfaces.at(share, all), film_.painters, share == 0.5 ? film_.window : none,
        plan_.cells);
    ++plan_.placed_instants;
    const ErrorForecast errors(still, *plan_.motion, film_.scene.splats.dilation_px2);
    parallel_for_each_index(plan_.cells.size(), [&](std::size_t c) {
      CellWork& work = plan_.cells[c];
      if (!work.adaptive || work.forecast || film_.surfaces.motion_px(work.index) > 0.0f) return;
      work.forecast = errors.of(work.cell, work.index, plan_.allowed_mean_square);
      if (work.forecast) work.count = work.forecast->count;
    });
    std::size_t open = 0;
    for (const CellWork& work : plan_.cells) open += work.adaptive && !work.forecast ? 1 : 0;
    if (4 * open <= plan_.cells.size()) break;
  }
}

/// By how far splats move in their own standard deviations, and discs.
void Planner::count_without_forecast(const SplatRow& standing) {
  if (plan_.motion != nullptr)
    plan_.motion->look_for_spreads(film_.scene, film_.exposure, film_.sets, standing, film_.math, film_.grid);
  // With time to spend the first look is a coarse one.
  const double first_db = film_.options.max_seconds > 0.0 ? 30.0 : film_.options.max_error_db;
  for (CellWork& work : plan_.cells) {
    if (!work.adaptive || work.forecast) continue;
    const bool splats_move = plan_.motion != nullptr && plan_.motion->moves(work.index);
    work.count =
        std::max(first_instants(film_.surfaces.motion_px(work.index), first_db, other_instants_per_px),
                 splats_move ? first_splat_instants(plan_.motion->spread(work.index), first_db) : 2);
    if (plan_.motion != nullptr)
      work.count = std::max(work.count, instants_of_jumps(plan_.motion->near_jumps_of(work.index)));
    if (work.has_middle) work.count |= 1;
  }
}

/// No fewer than show a splat that comes and goes during the exposure: where it does is not looked for.
void Planner::count_what_fades() {
  constexpr int most = 65;
  const double first_db = film_.options.max_seconds > 0.0 ? 30.0 : film_.options.max_error_db;
  const int least = std::min(most, first_splat_instants(plan_.motion->briefest(), first_db));
  for (CellWork& work : plan_.cells) {
    if (!work.adaptive || !plan_.motion->moves(work.index)) continue;
    work.count = std::max(work.count, least);
    if (work.has_middle) work.count |= 1;
  }
}

SplatPlan Planner::plan() {
  film_.lens.any() ? begin_behind_lens() : begin_cells();
  if (film_.options.samples == 0 && !film_.exposure.instant() && !film_.lens.any()) {
    const SplatRow standing(film_.scene, film_.sets, false, film_.exposure.open, film_.math, film_.grid,
                            std::vector<char>(film_.grid.size(), 1));
    if (plan_.motion != nullptr && film_.options.max_seconds == 0.0) forecast(standing);
    if (std::any_of(plan_.cells.begin(), plan_.cells.end(),
                    [](const CellWork& work) { return work.adaptive && !work.forecast; }))
      count_without_forecast(standing);
    if (plan_.motion != nullptr && plan_.motion->briefest() > 0.0f) count_what_fades();
  }
  share_instants(plan_.cells, moving_splats(film_.sets));
  for (CellWork& work : plan_.cells)
    if (work.has_middle && work.estimated) work.sums->weigh(work.weights(work.count / 2));
  // What is decided for a cell depends on the whole film, and not on what else is asked for.
  std::erase_if(plan_.cells, [&](const CellWork& work) { return !film_.window[work.index]; });
  return std::move(plan_);
}

}  // namespace

SplatPlan plan_splats(const SplatFilm& film) { return Planner(film).plan(); }

}  // namespace swept
