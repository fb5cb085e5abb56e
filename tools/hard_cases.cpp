// Pictures of every hard case of model section 10: the exact renderer, the reference, and their difference,
// with a table of how far apart they are. Exit codes: 0 all within what is required, 1 not, or a file could
// not be written, 2 bad arguments.
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <string>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "abuffer/abuffer.h"
#include "abuffer/reference/reference.h"
#include "splat/compare/metrics.h"
#include "splat/io/atomic_file.h"
#include "splat/io/image_file.h"
#include "tests/oracle/hard_scenes.h"

namespace {

using namespace swept;

/// The three side by side, each pixel of theirs `scale` wide and high.
Image side_by_side(const Image& a, const Image& b, const Image& c, int scale) {
  const int gap = scale;
  Image sheet;
  sheet.width = sheet.film_width = 3 * a.width * scale + 2 * gap;
  sheet.height = sheet.film_height = a.height * scale;
  sheet.rgba.assign(4 * sheet.pixel_count(), 1.0f);
  int left = 0;
  for (const Image* part : {&a, &b, &c}) {
    for (int y = 0; y < sheet.height; ++y)
      for (int x = 0; x < part->width * scale; ++x)
        std::copy_n(&part->rgba[4 * (static_cast<std::size_t>(y / scale) * part->width + x / scale)], 4,
                    &sheet.rgba[4 * (static_cast<std::size_t>(y) * sheet.width + left + x)]);
    left += part->width * scale + gap;
  }
  return sheet;
}

std::string decibels(double rmse) {
  return rmse > 0.0 ? fmt::format("{:.1f}", -20.0 * std::log10(rmse)) : "identical";
}

int run(const std::string& folder, const std::string& only, double samples_scale) {
  std::filesystem::create_directories(folder);
  std::string table =
      "| case | stills | PSNR, dB | required | the stills' own error, dB | largest difference | fragments in "
      "one "
      "pixel | intervals |\n|---|---|---|---|---|---|---|---|\n";
  std::string pictures;
  int exit_code = 0;
  for (const oracle::HardScene& hard : oracle::hard_scenes()) {
    if (!only.empty() && hard.name != only) continue;
    const Scene scene = hard.make();
    ReferenceOptions options;
    options.samples = std::max(2, 2 * static_cast<int>(samples_scale * hard.samples / 2));
    // Both along the same chords: what is judged is the rest.
    options.motion = ReferenceMotion::segments;
    const auto rendered = render_abuffer(scene, {.parabolas = false});
    const auto reference = render_reference(scene, options);
    if (!rendered || !reference) {
      fmt::print(stderr, "swept_hard_cases: {}: {}\n", hard.name,
                 (rendered ? reference.error() : rendered.error()).message());
      exit_code = 1;
      continue;
    }
    const auto metrics = compare_images(rendered->image, reference->image);
    const double own = reference->statistics.counter("reference_error_rmse").value_or(std::nan(""));
    if (!metrics || !(metrics->rmse <= std::pow(10.0, -hard.required_db / 20.0)) ||
        metrics->nonfinite_a > 0) {
      fmt::print(stderr, "swept_hard_cases: {}: further from the reference than required\n", hard.name);
      exit_code = 1;
    }
    if (!metrics) continue;
    // A power of ten that brings the largest difference to between 0.05 and 0.5.
    const double factor =
        metrics->max_abs > 0.0 ? std::pow(10.0, std::floor(std::log10(0.5 / metrics->max_abs))) : 1.0;
    const Image sheet =
        side_by_side(rendered->image, reference->image,
                     difference_image(rendered->image, reference->image, factor), 288 / scene.film.height);
    const std::string file = hard.name + ".png";
    if (const Status status = write_png(folder + "/" + file, sheet); !status) {
      fmt::print(stderr, "swept_hard_cases: {}\n", status.error().message());
      return 1;
    }
    table +=
        fmt::format("| `{}` | {} | {} | {:g} | {} | {:.1e} | {:g} | {:g} |\n", hard.name, options.samples,
                    decibels(metrics->rmse), hard.required_db, decibels(own), metrics->max_abs,
                    rendered->statistics.counter("fragments_in_fullest_pixel").value_or(std::nan("")),
                    rendered->statistics.counter("intervals").value_or(std::nan("")));
    pictures += fmt::format("\n`{}`: {}. Difference times {:g}.\n\n![{}]({})\n", hard.name, hard.shows,
                            factor, hard.name, file);
  }
  fmt::print("{}", table);
  const Status written = write_file(
      folder + "/index.md",
      "# Hard cases\n\nThe exact image, the mean of still images that judges it, and their difference.\n\n" +
          table + pictures);
  if (written) return exit_code;
  fmt::print(stderr, "swept_hard_cases: {}: {}\n", written.error().file, written.error().reason);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Pictures of Swept's hard cases beside the reference, and a table", "swept_hard_cases");
  std::string folder, only;
  double samples_scale = 1.0;
  app.add_option("folder", folder, "where the pictures and index.md go")->required();
  app.add_option("--only", only, "one case");
  app.add_option("--samples-scale", samples_scale, "times the stills that each case asks for")
      ->check(CLI::Range(0.01, 64.0))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
    return run(folder, only, samples_scale);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const std::exception& error) {
    fmt::print(stderr, "swept_hard_cases: {}\n", error.what());
    return 1;
  }
}
