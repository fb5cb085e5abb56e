// Tables of time: Rönnow's, and the hierarchy beside bins.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include <fmt/core.h>
#include <Eigen/Geometry>

#include "abuffer/abuffer.h"
#include "abuffer/stochastic/stochastic.h"
#include "splat/compare/metrics.h"
#include "tools/cpu_seconds.h"
#include "tools/study/mesh_tables.h"

namespace swept {
namespace {

using Json = nlohmann::ordered_json;

struct Timed {
  Rendered rendered;
  double seconds = 0.0;
};
template <class Render, class Options>
Result<Timed> timed(const Render& render, const Scene& scene, const Options& options) {
  RenderControl control;
  control.threads = 1;
  const double before = cpu_seconds();
  Result<Rendered> rendered = render(scene, options, control);
  if (!rendered) return rendered.error();
  return Timed{std::move(*rendered), cpu_seconds() - before};
}

double psnr_db(const Image& image, const Image& truth) {
  const Result<ImageMetrics> metrics = compare_images(image, truth);
  return metrics ? metrics->psnr_db : std::nan("");
}

/// Triangles of some two pixels anywhere before the camera, each moving by that many pixels its own way.
Scene loose_triangles(int side_px, int count, double motion_px) {
  Scene scene;
  scene.film = {side_px, side_px, 0, 0, 0, 0};
  scene.shutter = {0.0, 1.0};
  scene.camera.look_ats.emplace_back();
  const double unit = projection_of(scene.film, scene.camera.at(0.0)).focal_px / 5.0;  // px at the origin
  Object& object = scene.objects.emplace_back();
  object.cloud.keys.resize(1);
  SurfelPose& pose = object.cloud.keys.front().pose;
  // Of 10⁷ every byte counts: axes, which nobody looks at, are one for all.
  static const Eigen::Vector3f axis_u(0.01f, 0.0f, 0.0f), axis_v(0.0f, 0.01f, 0.0f);
  const std::size_t points = 3 * static_cast<std::size_t>(count);
  pose.axis_u = PointArray<Eigen::Vector3f>::view({&axis_u, points, 0});
  pose.axis_v = PointArray<Eigen::Vector3f>::view({&axis_v, points, 0});
  pose.position.own().reserve(points);
  object.cloud.color.own().reserve(points);
  object.cloud.velocity.own().reserve(points);
  object.triangles.reserve(static_cast<std::size_t>(count));
  std::mt19937_64 random(11);
  const auto uniform = [&](double most) {
    return most * (2.0 * static_cast<double>(random() >> 11) * 0x1p-53 - 1.0);
  };
  for (int t = 0; t < count; ++t) {
    const double x = uniform(1.4), y = uniform(1.4), z = uniform(1.4), turn = uniform(M_PI);
    const double speed = motion_px / unit;
    const Eigen::Vector3f color(0.5f + static_cast<float>(uniform(0.5)), 0.5f, 0.5f);
    for (int i = 0; i < 3; ++i) {
      const double dx = uniform(1.5 / unit), dy = uniform(1.5 / unit), dz = uniform(1.5 / unit);
      pose.position.push_back({x + dx, y + dy, z + dz});
      object.cloud.color.push_back(color);
      object.cloud.velocity.emplace_back(static_cast<float>(speed * std::cos(turn)),
                                         static_cast<float>(speed * std::sin(turn)), 0.0f);
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    object.triangles.push_back({first, first + 1, first + 2});
  }
  return scene;
}

/// What a scene of the paper's table is made of.
struct Glass {
  const char *name, *title;
  bool transparent, textured;
};
constexpr Glass glasses[] = {{"opaque", "", false, false},
                             {"painted", ", with a texture", false, true},
                             {"transparent", ", transparent", true, false},
                             {"textured", ", transparent, with a texture", true, true}};

/// Colours that change evenly from texel to texel; no light comes through.
std::shared_ptr<const Texture> patches() {
  auto texture = std::make_shared<Texture>();
  texture->width = texture->height = 16;
  std::mt19937_64 random(5);
  const auto channel = [&] { return static_cast<float>(static_cast<double>(random() >> 11) * 0x1p-53); };
  for (int i = 0; i < 256; ++i) texture->texels.emplace_back(channel(), channel(), channel(), 1.0f);
  return texture;
}

void make(const Glass& glass, Object& object) {
  if (!glass.transparent && !glass.textured) return;
  // White: looks that change, as normals do, hold in place of opacities.
  object.cloud.looks.clear();
  object.cloud.color.clear();
  if (glass.transparent) object.cloud.opacity.own().assign(object.cloud.size(), 0.5f);
  if (!glass.textured) return;
  // Laid over it from the front, four times from end to end.
  object.texture = patches();
  const PointArray<Eigen::Vector3d>& position = object.cloud.keys.front().pose.position;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& at : position) box.extend(at);
  for (const Triangle& triangle : object.triangles) {
    TextureCorners& corners = object.texture_corners.emplace_back();
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] =
          (4.0 * (position[triangle[i]] - box.min()).head<2>() / box.sizes().maxCoeff()).cast<float>();
  }
}

}  // namespace

StudyTable ronnow_table(const std::vector<TraversalScene>& scenes, const MeshTableOptions& options,
                        const RowDone& done) {
  StudyTable table{
      "ronnow",
      "Table 1 of Rönnow et al. 2021",
      "CPU seconds of one thread. Intervals are those of 16 places a pixel, memory what they take at "
      "once. PSNR of the stochastic method is against the exact picture; the last columns are "
      "the exact method with the fewest intervals a place, of 2 to 32, that are as good.",
      {"scene", "film, px", "triangles", "exact, s", "intervals, 10⁶", "most in a pixel", "MiB",
       "stochastic 128, s", "PSNR, dB", "stochastic to exact", "K as good", "its s", "stochastic to it"},
      {}};
  const std::vector<int> films =
      options.films_px.empty() ? std::vector{options.side_px, 2 * options.side_px} : options.films_px;
  const auto asked = [&](const Glass& glass) {
    return options.looks.empty() ||
           std::find(options.looks.begin(), options.looks.end(), glass.name) != options.looks.end();
  };
  for (const TraversalScene& of : scenes)
    for (const Glass& glass : glasses)
      for (const int side : films) {
        if (!asked(glass)) continue;
        const std::string title = of.title + glass.title;
        const auto failed = [&](const std::string& why) {
          table.rows.push_back({title, why});
          table.rows.back().resize(table.columns.size());
          ++table.failed;
          done(table);
        };
        if (!of.error.empty()) {
          failed(of.error);
          continue;
        }
        Scene scene = of.scene;
        scene.film = {side, side, 0, 0, 0, 0};
        for (Object& object : scene.objects) make(glass, object);
        const Result<Timed> exact = timed(render_abuffer, scene, AbufferOptions{}),
                            random = timed(render_stochastic, scene, StochasticOptions{});
        if (!exact || !random) {
          failed(!exact ? exact.error().message() : random.error().message());
          continue;
        }
        const Statistics& counts = exact->rendered.statistics;
        const double db = psnr_db(random->rendered.image, exact->rendered.image);
        Json most = nullptr, seconds = nullptr, ratio = nullptr;
        // Of the smaller film and one colour alone: elsewhere it is the same, and takes long.
        for (const std::size_t k : {2, 4, 8, 16, 32}) {
          if (!options.films_px.empty() || side != options.side_px || glass.textured) break;
          AbufferOptions few;
          few.place_intervals = k;
          const Result<Timed> lossy = timed(render_abuffer, scene, few);
          if (!lossy || !(psnr_db(lossy->rendered.image, exact->rendered.image) >= db)) continue;
          most = k, seconds = lossy->seconds, ratio = random->seconds / lossy->seconds;
          break;
        }
        table.rows.push_back({title, side, counts.counter("triangles").value_or(0.0), exact->seconds,
                              counts.counter("fragments").value_or(0.0) / 1e6,
                              counts.counter("fragments_in_fullest_pixel").value_or(0.0),
                              32.0 * counts.counter("fragments_held").value_or(0.0) / 0x1p20, random->seconds,
                              db, random->seconds / exact->seconds, most, seconds, ratio});
        done(table);
      }
  return table;
}

StudyTable hierarchy_table(const MeshTableOptions& options, const RowDone& done) {
  constexpr int samples = 16;
  StudyTable table{
      "hierarchy",
      "Tiles, intervals, what is chosen of them, and the hierarchy of moving boxes",
      fmt::format("The stochastic method, {} samples a pixel, {} px, CPU seconds of one thread with "
                  "what building takes; triangles of some two pixels, each going its own way. "
                  "The hierarchy is left out where there are more than 10⁶ triangles, or triangles times px.",
                  samples, options.side_px),
      {"triangles", "motion, px", "TILE 4×4, s", "INTERVAL 16, s", "auto, s", "auto to the better one",
       "chosen", "hierarchy, s", "hierarchy to the better one"},
      {}};
  const std::vector<int> counts =
      options.triangles.empty() ? std::vector{10'000, 100'000, 1'000'000} : options.triangles;
  const std::vector<double> motions =
      options.motions_px.empty() ? std::vector{0.0, 10.0, 30.0, 100.0, 300.0} : options.motions_px;
  for (const int count : counts)
    for (const double px : motions) {
      if (options.quick && (px * count > 1e5 || count > 10'000)) continue;
      const Scene scene = loose_triangles(options.side_px, count, px);
      std::string failed;
      double chosen_ratio = 0.0;
      const auto seconds = [&](Traversal traversal) -> Json {
        const Result<Timed> made =
            timed(render_stochastic, scene, StochasticOptions{.samples = samples, .traversal = traversal});
        if (!made) {
          failed = made.error().message();
          return nullptr;
        }
        const Statistics& statistics = made->rendered.statistics;
        if (traversal == Traversal::automatic)
          chosen_ratio = statistics.counter("forecast_tile_us").value_or(0.0) -
                         statistics.counter("forecast_interval_us").value_or(0.0);
        return made->seconds;
      };
      const Json tile = seconds(Traversal::tile), interval = seconds(Traversal::interval),
                 chosen = seconds(Traversal::automatic);
      const bool boxes_too = hierarchy_available() && std::max(1.0, px) * count <= 1e6;
      const Json boxes = boxes_too ? seconds(Traversal::hierarchy) : Json(nullptr);
      if (!failed.empty()) {
        table.rows.push_back({count, failed});
        table.rows.back().resize(table.columns.size());
        ++table.failed;
        done(table);
        continue;
      }
      const double better = std::min(tile.get<double>(), interval.get<double>());
      table.rows.push_back({count, px, tile, interval, chosen, chosen.get<double>() / better,
                            chosen_ratio > 0.0 ? "INTERVAL" : "TILE", boxes,
                            boxes_too ? Json(boxes.get<double>() / better) : Json(nullptr)});
      done(table);
    }
  return table;
}

}  // namespace swept
