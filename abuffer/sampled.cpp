#include "abuffer/sampled.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abuffer/lens_looks.h"
#include "abuffer/parallel.h"
#include "abuffer/progress_of.h"
#include "abuffer/render_valid.h"
#include "abuffer/resolve/cell_image.h"
#include "abuffer/resolve/sample_plan.h"
#include "abuffer/resolve/sampled_cell.h"
#include "abuffer/simd/sampled_math.h"
#include "abuffer/sources/instant_table.h"
#include "abuffer/sources/packet_blur.h"
#include "abuffer/sources/point_packets.h"
#include "abuffer/splats/splat_frame.h"
#include "abuffer/splats/splat_packets.h"
#include "abuffer/tiles/cells.h"
#include "abuffer/tiles/point_lists.h"
#include "splat/stopwatch.h"

namespace swept {
namespace {

/// A cell as far as it has come.
struct CellProgress {
  int instants = 0;  ///< that it was looked at
  int count = 0;     ///< the image's weight
  std::optional<ErrorEstimate> estimate;
  double step_seconds = 0.0;  ///< what its last instants took
  CellImage so_far;           ///< its sums, where there are seconds to spend
  [[nodiscard]] double squares() const { return estimate ? estimate->squares() : 0.0; }
};

class Renderer {
 public:
  Renderer(const Scene& scene, const SampledOptions& options, const RenderControl& control)
      : scene_(scene), options_(options), control_(control), exposure_(scene.exposure()) {}

  Result<Rendered> render() {
    if (scene_.camera.aperture.radius > 0.0) {
      if (Status status = refuse_row_delay(scene_, "a lens"); !status) return status.error();
      lens_ = LensLooks(scene_, options_.samples);
      if (Status status = check_lens(lens_, options_); !status) return status.error();
    }
    const Exposure all_rows = exposure_.of_all_rows(scene_.film.height);
    const std::size_t bytes = packed_bytes(scene_, all_rows);
    if (options_.max_seconds > 0.0 && exposure_.row_delay != 0.0)
      return Error{"", "max_seconds", "does not go with rows that are exposed one after the other",
                   ErrorKind::unsupported};
    if (Status fits = check_bytes(bytes, control_, "the points"); !fits) return fits.error();
    if (options_.max_seconds > 0.0)
      if (Status fits = check_bytes(bytes + kept_bytes(), control_,
                                    "points and what is kept of cells between refinements");
          !fits)
        return fits.error();
    Stopwatch watch;
    Rendered out;
    const std::vector<PointPackets> objects = pack_points(scene_, all_rows, options_.only_standing);
    out.statistics.time("packets", watch.lap());
    const PacketBins bins(scene_, exposure_, objects);
    out.statistics.time("bins", watch.lap());
    out.image = blank_image(scene_.film);
    image_ = &out.image;
    if (options_.error_channel)
      out.image.channels.push_back({"error", std::vector<float>(out.image.pixel_count())});
    bins_ = &bins;
    // A lens and rows of their own have their own ways to look at a cell.
    if (!lens_.any() && exposure_.row_delay == 0.0) lists_.emplace(scene_, exposure_, objects, bins);
    if (lens_.any()) blur_.emplace(scene_, exposure_, objects);
    plan();

    const SampledMaths maths = sampled_maths();
    const std::size_t which =
        options_.implementation < 0
            ? maths.count - 1
            : std::min(static_cast<std::size_t>(options_.implementation), maths.count - 1);
    InstantTable table(scene_, exposure_, objects, lens_);
    PerThread<SampledCell> cells([&] { return SampledCell(scene_, objects, maths.first[which]); });
    progress_.resize(window_cells_.size());
    if (exposure_.row_delay != 0.0 && options_.samples == 0) {
      render_rows(cells, table);
    } else if (options_.max_seconds > 0.0) {
      render_for(options_.max_seconds, cells, table);
    } else {
      ProgressOf done(control_, window_cells_.size());
      parallel_for_each_cell([&](std::size_t i) {
        render_cell(i, cells.local(), table);
        done.one_more();
      });
    }
    if (control_.stop.stop_requested()) return stopped_error();
    out.statistics.time("cells", watch.lap());
    SampledCounters total;
    for (const SampledCell& cell : cells) total.add(cell.counters);
    describe(objects, total, maths.first[which], out.statistics);
    for (std::size_t i = 0; i < progress_.size(); ++i) {
      const Cell cell = bins.cell(window_cells_[i]);
      out.parts.push_back({cell.x, cell.y, cell.width, cell.height, progress_[i].instants});
    }
    return out;
  }

 private:
  /// Cells of the window, and how much error each that moves may have.
  void plan() {
    double moving_px = 0.0, shares = 0.0;
    allowed_squares_.assign(bins_->cell_count(), 0.0);
    for (std::size_t c = 0; c < bins_->cell_count(); ++c) {
      const Cell cell = bins_->cell(c);
      const std::span<const PacketRef> packets = bins_->packets(c);
      const double px = double{1.0} * cell.width * cell.height;
      const float motion = exposure_.instant() ? 0.0f : typical_motion(*bins_, packets);
      if (lens_.any() ? !packets.empty() : motion > 0.0f) {
        int looks = first_of(motion, options_.max_error_db);
        if (lens_.any() && !lens_.given()) looks = first_looks(blur_->of(packets), looks);
        moving_px += px;
        allowed_squares_[c] = error_share(px, packets.size(), looks);
        shares += allowed_squares_[c];
      }
      if (in_window(cell, *image_)) window_cells_.push_back(c);
    }
    // What stands still has no error, so that what moves may have more.
    const double film_px = double{1.0} * scene_.film.width * scene_.film.height;
    const double allowed = slack(moving_px / (cell_px * cell_px), options_.max_error_db, lens_.any()) *
                           std::pow(10.0, -0.1 * options_.max_error_db) * 3.0 * film_px;
    for (std::size_t c = 0; c < allowed_squares_.size(); ++c) {
      if (allowed_squares_[c] == 0.0) continue;
      allowed_squares_[c] *= allowed / shares;
      const Cell cell = bins_->cell(c);
      if (options_.max_cell_error_db > 0.0)
        allowed_squares_[c] =
            std::min(allowed_squares_[c],
                     std::pow(10.0, -0.1 * options_.max_cell_error_db) * 3.0 * cell.width * cell.height);
    }
  }

  /// body(i) for every cell of the window, until the render is stopped.
  template <class Body>
  void parallel_for_each_cell(const Body& body) const {
    parallel_for_parts(tbb::blocked_range<std::size_t>(0, window_cells_.size(), 1), [&](const auto& range) {
      for (std::size_t i = range.begin(); i != range.end(); ++i)
        if (!control_.stop.stop_requested()) body(i);
    });
  }

  void render_cell(std::size_t i, SampledCell& renderer, InstantTable& table) {
    begin_cell(i, options_.max_error_db, renderer, table);
    CellProgress& cell = progress_[i];
    if (options_.samples == 0 && cell.estimate) {
      while (cell.squares() > allowed_squares_[window_cells_[i]] && cell.count < most_chosen_instants)
        double_instants(i, renderer, table);
    }
    finish_cell(i, renderer);
  }

  /// Where little light comes in, much of the motion is in little of the light's time: a pixel of motion is
  /// then no measure of how errors fall.
  [[nodiscard]] bool foreseen() const { return !lens_.any() && !exposure_.curve; }
  [[nodiscard]] int first_of(float motion_px, double error_db) const {
    return first_instants(motion_px, error_db, foreseen() ? disc_instants_per_px : other_instants_per_px);
  }
  [[nodiscard]] ErrorEstimate estimate_of(const SampledCell& renderer, int count, float motion_px) const {
    return foreseen() ? ErrorEstimate(renderer.squares(), count, motion_px)
                      : ErrorEstimate(renderer.squares(), count, ErrorEstimate::of_edges);
  }

  /// Cells of a single row say too little about their error: those of a square share their number of
  /// instants, which begins anew when it doubles.
  void render_rows(PerThread<SampledCell>& cells, InstantTable& table) {
    const std::size_t columns = static_cast<std::size_t>((scene_.film.width + cell_px - 1) / cell_px);
    const std::size_t squares_down = static_cast<std::size_t>((scene_.film.height + cell_px - 1) / cell_px);
    std::vector<std::size_t> window_index(bins_->cell_count(), bins_->cell_count());
    for (std::size_t i = 0; i < window_cells_.size(); ++i) window_index[window_cells_[i]] = i;
    ProgressOf done(control_, columns * squares_down);
    parallel_for_parts(tbb::blocked_range<std::size_t>(0, columns * squares_down, 1), [&](const auto& range) {
      for (std::size_t square = range.begin(); square != range.end(); ++square) {
        std::vector<std::size_t> rows;
        bool seen = false;
        for (std::size_t y = square / columns * cell_px;
             y < std::min((square / columns + 1) * cell_px, bins_->cell_count() / columns); ++y) {
          rows.push_back(y * columns + square % columns);
          seen = seen || window_index[rows.back()] < window_cells_.size();
        }
        if (seen && !control_.stop.stop_requested()) render_square(rows, window_index, cells.local(), table);
        done.one_more();
      }
    });
  }

  void render_square(const std::vector<std::size_t>& rows, const std::vector<std::size_t>& window_index,
                     SampledCell& renderer, InstantTable& table) {
    double allowed = 0.0;
    int first = 1;
    for (const std::size_t row : rows) {
      allowed += allowed_squares_[row];
      if (!exposure_.instant())
        first = std::max(first, first_of(typical_motion(*bins_, bins_->packets(row)), options_.max_error_db));
    }
    for (int count = first;; count *= 2) {
      double squares = 0.0;
      for (const std::size_t row : rows) {
        renderer.begin(bins_->cell(row), bins_->packets(row));
        for (int k = 0; k < count; ++k) {
          throw_if_stopped(control_.stop);
          renderer.add(*table.at(2 * k + 1, 2 * count, bins_->cell(row).y),
                       count > 1 ? estimating_weights(k, count) : InstantWeights{});
        }
        std::optional<ErrorEstimate> estimate;
        if (count > 1)
          squares += estimate
                         .emplace(estimate_of(
                             renderer, count,
                             exposure_.instant() ? 0.0f : typical_motion(*bins_, bins_->packets(row))))
                         .squares();
        const std::size_t i = window_index[row];
        if (i >= window_cells_.size()) continue;
        progress_[i].count = progress_[i].instants = count;
        progress_[i].estimate = estimate;
        finish_cell(i, renderer);
      }
      if (squares <= allowed || 2 * count > most_chosen_instants || control_.stop.stop_requested()) return;
    }
  }

  void begin_of(std::size_t i, SampledCell& renderer) const {
    const Cell cell = bins_->cell(window_cells_[i]);
    std::optional<CellPackets> own;
    if (lists_) own = lists_->of(window_cells_[i]);
    if (own)
      renderer.begin(cell, *std::move(own));
    else
      renderer.begin(cell, bins_->packets(window_cells_[i]));
  }

  /// A cell's first instants.
  void begin_cell(std::size_t i, double error_db, SampledCell& renderer, InstantTable& table) {
    const std::span<const PacketRef> packets = bins_->packets(window_cells_[i]);
    begin_of(i, renderer);
    if (lens_.any()) return begin_behind_lens(i, error_db, renderer, table);
    const float motion = exposure_.instant() ? 0.0f : typical_motion(*bins_, packets);
    const int row = bins_->cell(window_cells_[i]).y;
    CellProgress& cell = progress_[i];
    cell.count = motion > 0.0f ? options_.samples : 1;
    if (cell.count == 0) cell.count = first_of(motion, error_db);
    const bool estimated =
        motion > 0.0f && cell.count > 1 && (options_.samples == 0 || options_.error_channel);
    for (int k = 0; k < cell.count; ++k) {
      throw_if_stopped(control_.stop);
      InstantWeights weights;
      if (estimated) weights = estimating_weights(k, cell.count);
      renderer.add(*table.at(2 * k + 1, 2 * cell.count, row), weights);
    }
    cell.instants = cell.count;
    if (estimated) cell.estimate = estimate_of(renderer, cell.count, motion);
  }

  /// The first looks through the lens. Of given points each at instants of its own, as many in all as it
  /// takes or more.
  void begin_behind_lens(std::size_t i, double error_db, SampledCell& renderer, InstantTable& table) {
    const std::span<const PacketRef> packets = bins_->packets(window_cells_[i]);
    const float motion = exposure_.instant() ? 0.0f : typical_motion(*bins_, packets);
    CellProgress& cell = progress_[i];
    int instants = motion > 0.0f ? options_.samples : 1;
    if (instants == 0) instants = first_of(motion, error_db);
    if (lens_.given()) {
      const int points = lens_.points();
      // Of what moves a single instant for each point leaves the two too much to chance.
      const int wanted = options_.samples == 0 && instants > 1 ? std::max(instants, 2 * points) : instants;
      instants = (wanted + points - 1) / points;
      cell.count = points * instants;
    } else {
      cell.count = packets.empty() ? 1 : first_looks(blur_->of(packets), instants);
    }
    const bool estimated = !lens_.given() && cell.count > 1;
    for (int k = 0; k < cell.count; ++k) {
      throw_if_stopped(control_.stop);
      InstantWeights weights;
      if (estimated) weights.alternating = half_of_looks(k, cell.count);
      renderer.add(*table.look(k, instants), weights);
    }
    cell.instants = cell.count;
    if (estimated) cell.estimate.emplace(renderer.squares(), cell.count, ErrorEstimate::of_lens);
  }

  /// As many looks again.
  void double_looks(std::size_t i, SampledCell& renderer, InstantTable& table) {
    CellProgress& cell = progress_[i];
    renderer.alternate_from_sums(cell.count);
    for (int k = cell.count; k < 2 * cell.count; ++k) {
      throw_if_stopped(control_.stop);
      renderer.add(*table.look(k, 1), {1.0f, -1.0f, 0.0f, 0.0f});
    }
    cell.count *= 2;
    cell.instants = cell.count;
    cell.estimate->refine(renderer.squares(), cell.count);
  }

  /// By the instants half-way between; the first time with those at both ends, at half weight, so that the
  /// rule is the trapezoid's.
  void double_instants(std::size_t i, SampledCell& renderer, InstantTable& table) {
    if (lens_.any()) return double_looks(i, renderer, table);
    CellProgress& cell = progress_[i];
    const int row = bins_->cell(window_cells_[i]).y;
    const int count = cell.count;
    const bool at_ends = cell.instants == count;
    renderer.alternate_from_sums(count);
    const int added = at_ends ? count + 1 : count;
    for (int k = 0; k < added; ++k) {
      throw_if_stopped(control_.stop);
      const float w = at_ends && (k == 0 || k == count) ? 0.5f : 1.0f;
      renderer.add(at_ends ? *table.at(k, count, row) : *table.at(2 * k + 1, 2 * count, row),
                   {w, -w, 0.0f, 0.0f});
    }
    cell.instants += added;
    cell.count = 2 * count;
    cell.estimate->refine(renderer.squares(), cell.count);
  }

  void finish_cell(std::size_t i, SampledCell& renderer) {
    thread_local CellImage pixels;
    renderer.image(progress_[i].count, pixels);
    store(i, pixels);
    if (options_.error_channel) store_error(i, renderer);
  }

  /// Refines until so many seconds have passed since the render began. A doubling takes away most of a cell's
  /// squared error; so those cells go first that have most of it for the seconds that it takes.
  void render_for(double seconds, PerThread<SampledCell>& cells, InstantTable& table) {
    constexpr double coarse_db = 30.0;
    ProgressOf done(control_, 1);
    // One step of a cell, and what is kept of it.
    const auto step = [&](std::size_t i, const auto& add_instants) {
      SampledCell& renderer = cells.local();
      Stopwatch own;
      add_instants(renderer);
      if (options_.error_channel) store_error(i, renderer);
      renderer.image(1.0, progress_[i].so_far);
      progress_[i].step_seconds = own.lap();
      done.reached(std::min(0.99, begun_.so_far() / seconds));
    };
    parallel_for_each_cell([&](std::size_t i) {
      step(i, [&](SampledCell& renderer) { begin_cell(i, coarse_db, renderer, table); });
    });
    for (std::atomic<bool> refined{true}; refined && !control_.stop.stop_requested();) {
      refined = false;
      double best = 0.0;
      for (std::size_t i = 0; i < progress_.size(); ++i) best = std::max(best, gain(i));
      if (best == 0.0) break;
      parallel_for_each_cell([&](std::size_t i) {
        CellProgress& cell = progress_[i];
        // A doubling divides the gain by eight or more: a round takes what is within that of the best.
        if (gain(i) < 0.125 * best) return;
        const double needs = cell.step_seconds * (cell.instants == cell.count && !lens_.any() ? 1.0 : 2.0);
        if (begun_.so_far() + needs > seconds) return;
        step(i, [&](SampledCell& renderer) {
          begin_of(i, renderer);
          renderer.resume(cell.so_far);
          double_instants(i, renderer, table);
        });
        refined = true;
      });
    }
    parallel_for_each_cell([&](std::size_t i) {
      CellImage& image = progress_[i].so_far;
      for (double& value : image.rgba) value /= progress_[i].count;
      for (double& value : image.depth) value /= progress_[i].count;
      store(i, image);
    });
  }

  /// Squared error that a cell may lose for a second's work; 0 where it is as good as a picture can show.
  [[nodiscard]] double gain(std::size_t i) const {
    constexpr double unseen = 1e-12;  // of the mean square: 120 dB
    const CellProgress& cell = progress_[i];
    const Cell area = bins_->cell(window_cells_[i]);
    if (!cell.estimate || cell.count >= most_chosen_instants ||
        cell.squares() <= unseen * 3.0 * area.width * area.height)
      return 0.0;
    return cell.squares() / std::max(cell.step_seconds, 1e-9);
  }

  /// What is kept of the film's cells in render_for().
  [[nodiscard]] std::size_t kept_bytes() const {
    const auto cells = [](int px) { return static_cast<std::size_t>((px + cell_px - 1) / cell_px); };
    return cells(scene_.film.width) * cells(scene_.film.height) * cell_px * cell_px * 5 * sizeof(double);
  }

  void store(std::size_t i, const CellImage& pixels) {
    store_cell(bins_->cell(window_cells_[i]), pixels, scene_.background, *image_);
  }

  void store_error(std::size_t i, const SampledCell& renderer) {
    if (!progress_[i].estimate) return;
    thread_local std::vector<float> squares;
    renderer.alternating_squares(progress_[i].estimate->per_alternating(), squares);
    store_cell_error(bins_->cell(window_cells_[i]), squares, *image_, image_->channels.front().values);
  }

  void describe(const std::vector<PointPackets>& objects, const SampledCounters& total,
                const SampledMath& math, Statistics& s) const {
    double surfels = 0.0, packets = 0.0, instants = 0.0, px = 0.0, squares = 0.0, worst = 0.0;
    int most = 0;
    for (const PointPackets& object : objects) {
      surfels += static_cast<double>(object.size);
      packets += static_cast<double>(object.count);
    }
    for (std::size_t i = 0; i < progress_.size(); ++i) {
      const Cell cell = bins_->cell(window_cells_[i]);
      const double area = double{1.0} * cell.width * cell.height;
      px += area;
      instants += area * progress_[i].instants;
      most = std::max(most, progress_[i].instants);
      squares += progress_[i].squares();
      worst = std::max(worst, progress_[i].squares() / (3.0 * area));
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
    if (lens_.any()) describe_lens(lens_, most, s);
    if (!lens_.given() && (options_.samples == 0 || options_.error_channel))
      count_expected_error(squares, px, worst, s);
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
  LensLooks lens_;
  std::optional<PacketBlur> blur_;   ///< where there is a lens
  std::optional<PointLists> lists_;  ///< where there is none
  std::vector<std::size_t> window_cells_;
  std::vector<double> allowed_squares_;  ///< by cell of the film, Σ over pixels and R, G, B; 0: nothing moves
  std::vector<CellProgress> progress_;
  Stopwatch begun_;
};

}  // namespace

Status SampledOptions::validate() const {
  if (samples < 0 || samples > 1 << 20)
    return Error{"", "samples", "must be in [1, 1048576], or 0 to have them chosen"};
  if (!(max_error_db > 0.0 && max_error_db <= 150.0))
    return Error{"", "max_error_db", "must be above 0 and at most 150"};
  if (!(max_cell_error_db >= 0.0 && max_cell_error_db <= 150.0))
    return Error{"", "max_cell_error_db", "must be above 0 and at most 150, or 0 where it is not asked for"};
  if (!(max_seconds >= 0.0 && max_seconds <= 1e9))
    return Error{"", "max_seconds", "must be above 0 and at most 1e9, or 0 where it is not asked for"};
  if (max_seconds > 0.0 && samples > 0)
    return Error{"", "max_seconds", "chooses the instants, and so do samples: one of the two"};
  if (implementation < -1) return Error{"", "implementation", "must be −1 or more"};
  return Done{};
}

Result<Rendered> render_sampled(const Scene& scene, const SampledOptions& options,
                                const RenderControl& control) {
  const bool mixed = std::any_of(scene.objects.begin(), scene.objects.end(), [](const Object& object) {
    return object.splats.size() > 0 || !object.triangles.empty();
  });
  if (mixed) {
    if (Status status = scene.validate(); !status) return status.error();
    if (Status status = check_splats(scene); !status) return status.error();
    if (Status status = refuse_row_delay(scene, "the engine of splats and triangles"); !status)
      return status.error();
  }
  return render_valid(scene, options, control, [&](const auto&... all) {
    return mixed ? render_splats(all...) : Renderer(all...).render();
  });
}

}  // namespace swept
