#include "tools/compare_command.h"

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include <fmt/core.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "splat/compare/metrics.h"
#include "splat/io/image_file.h"
#include "tools/check_number.h"
#include "tools/console.h"

namespace swept {
namespace {

struct CompareArguments {
  std::string a, b, difference;
  double scale = 1.0;
  std::optional<double> min_psnr_db;
  bool json = false;
  CompareOptions options;
};

void print_json(const CompareArguments& arguments, const ImageMetrics& m) {
  // What is infinite or undefined becomes null.
  const nlohmann::ordered_json report = {{"a", arguments.a},
                                         {"b", arguments.b},
                                         {"pixels", m.pixels},
                                         {"nonfinite_a", m.nonfinite_a},
                                         {"nonfinite_b", m.nonfinite_b},
                                         {"identical", m.identical},
                                         {"rmse", m.rmse},
                                         {"psnr_db", m.psnr_db},
                                         {"ssim", m.ssim},
                                         {"flip", m.flip},
                                         {"max_abs", m.max_abs},
                                         {"max_abs_pixel", {m.max_abs_x, m.max_abs_y}},
                                         {"share_over_1_255", m.share_over_1_255},
                                         {"alpha_rmse", m.alpha_rmse},
                                         {"alpha_max_abs", m.alpha_max_abs}};
  // A path need not be UTF-8.
  fmt::print("{}\n", report.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
}

void print_text(const ImageMetrics& m) {
  fmt::print("pixels      {}{}\n", m.pixels, m.identical ? ", all identical" : "");
  if (m.nonfinite_a + m.nonfinite_b > 0) {
    fmt::print("NOT FINITE  {} pixels of the first image, {} of the second; the figures leave them out\n",
               m.nonfinite_a, m.nonfinite_b);
  }
  fmt::print("rmse        {:.6g}\n", m.rmse);
  fmt::print("psnr        {:.3f} dB\n", m.psnr_db);
  fmt::print("ssim        {:.6f}\n", m.ssim);
  fmt::print("flip        {:.6f}\n", m.flip);
  fmt::print("worst       {:.6g} at pixel {}, {}\n", m.max_abs, m.max_abs_x, m.max_abs_y);
  fmt::print("over 1/255  {:.4f} % of the pixels\n", 100.0 * m.share_over_1_255);
  fmt::print("alpha       rmse {:.6g}, worst {:.6g}\n", m.alpha_rmse, m.alpha_max_abs);
}

Status write_difference(const CompareArguments& arguments, const Image& a, const Image& b) {
  const Image image = difference_image(a, b, arguments.scale, arguments.options);
  return std::filesystem::path(arguments.difference).extension() == ".png"
             ? write_png(arguments.difference, image)
             : write_exr(arguments.difference, image);
}

Error of_both(const CompareArguments& arguments, const Error& problem) {
  return {arguments.a + " and " + arguments.b, problem.field, problem.reason};
}

/// Before any pixel is read: a small file may unpack to gigabytes.
Status check_headers(const CompareArguments& arguments) {
  const Result<Image> a = read_exr_window(arguments.a);
  if (!a) return a.error();
  const Result<Image> b = read_exr_window(arguments.b);
  if (!b) return b.error();
  if (const Status s = check_windows(*a, *b, arguments.options); !s) return of_both(arguments, s.error());
  return Done{};
}

/// The figures are printed even if what follows fails.
Status compare(const CompareArguments& arguments) {
  for (const std::string* input : {&arguments.a, &arguments.b}) {
    std::error_code code;
    if (!arguments.difference.empty() && std::filesystem::equivalent(arguments.difference, *input, code))
      return Error{arguments.difference, "--difference", "is one of the images compared"};
  }
  if (const Status same = check_headers(arguments); !same) return same;
  const Result<Image> a = read_exr(arguments.a);
  if (!a) return a.error();
  const Result<Image> b = read_exr(arguments.b);
  if (!b) return b.error();
  const Result<ImageMetrics> compared = compare_images(*a, *b, arguments.options);
  if (!compared) return of_both(arguments, compared.error());
  const ImageMetrics& metrics = *compared;
  if (arguments.json) {
    print_json(arguments, metrics);
  } else {
    print_text(metrics);
  }
  if (!arguments.difference.empty()) {
    if (const Status written = write_difference(arguments, *a, *b); !written) return written.error();
  }
  if (!arguments.min_psnr_db) return Done{};
  if (metrics.nonfinite_a + metrics.nonfinite_b > 0) {
    return Error{arguments.b, "--min-psnr", "pixels that are not finite meet no limit"};
  }
  // Written so that an undefined figure fails.
  if (!(metrics.psnr_db >= *arguments.min_psnr_db)) {
    return Error{
        arguments.b, "--min-psnr",
        fmt::format("{:.3f} dB is below the limit of {} dB", metrics.psnr_db, *arguments.min_psnr_db)};
  }
  return Done{};
}

std::string check_difference_name(const std::string& name) {
  const std::string extension = std::filesystem::path(name).extension().string();
  return extension == ".png" || extension == ".exr" ? "" : "must end in .png or .exr: " + name;
}

}  // namespace

void add_compare_command(CLI::App& app, int& exit_code) {
  const auto arguments = std::make_shared<CompareArguments>();
  CLI::App* command = app.add_subcommand(
      "compare", "Compare two EXR images on linear RGB: RMSE, PSNR (peak 1), SSIM, FLIP, worst pixel");
  command->footer(
      std::string("Examples:\n"
                  "  swept compare right.exr other.exr\n"
                  "  swept compare right.exr other.exr --min-psnr 60 --difference apart.png --scale 10\n"
                  "\n") +
      exit_codes_help);
  command->add_option("a", arguments->a, "The image that is right")->required();
  command->add_option("b", arguments->b, "The image to judge")->required();
  command->add_flag(
      "--json", arguments->json,
      "Print JSON; what is infinite or undefined, such as the PSNR of identical images, is null");
  command
      ->add_option("--difference", arguments->difference,
                   "Write the absolute difference of the colours to this .png or .exr; what is not finite is "
                   "magenta")
      ->check(check_difference_name);
  command->add_option("--scale", arguments->scale, "Multiply the written difference by this")
      ->check(CLI::PositiveNumber)
      ->check(check_is_number)
      ->capture_default_str();
  command->add_option("--min-psnr", arguments->min_psnr_db, "Exit with 1 if the PSNR is below this, in dB")
      ->check(check_is_number);
  command->add_flag("--crop-to-overlap", arguments->options.crop_to_overlap,
                    "Compare where the two windows overlap; by default they must agree");
  command->callback([arguments, &exit_code] {
    const Status status = compare(*arguments);
    exit_code = status.ok() ? 0 : 1;
    if (!status) log("swept compare: {}\n", status.error().message());
  });
}

}  // namespace swept
