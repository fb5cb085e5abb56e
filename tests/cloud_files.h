// Small point files as other programs write them, and the command that draws them in a folder of its own.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/temporary_folder.h"

namespace swept::test {

class CloudCommandFolder : public ::testing::Test {
 protected:
  /// Runs `swept` in the test's folder.
  Outcome swept(const std::vector<std::string>& arguments) const {
    std::string line = "cd '" + (folder_ / "") + "' && " + SWEPT_COMMAND;
    for (const std::string& argument : arguments) line += " '" + argument + "'";
    return run_command("(" + line + ")");
  }

  /// A small picture of the points, which fills a part of it and stands in its middle.
  std::string drawn(const std::string& points) const {
    const Outcome outcome = swept({"render", points, "-o", "a.exr", "--size", "96x54", "--overwrite"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    expect_well_framed("a.exr");
    return outcome.err;
  }

  void expect_well_framed(const std::string& name) const {
    const Result<Image> image = read_exr(folder_ / name);
    ASSERT_TRUE(image.ok()) << image.error().message();
    int left = image->width, right = -1, top = image->height, bottom = -1, covered = 0;
    for (int y = 0; y < image->height; ++y)
      for (int x = 0; x < image->width; ++x) {
        const float alpha = image->rgba[4 * static_cast<std::size_t>(y * image->width + x) + 3];
        covered += alpha > 0.5f ? 1 : 0;
        if (!(alpha > 0.1f)) continue;
        left = std::min(left, x);
        right = std::max(right, x);
        top = std::min(top, y);
        bottom = std::max(bottom, y);
      }
    const double share = covered / static_cast<double>(image->pixel_count());
    EXPECT_GT(share, 0.05) << name;
    EXPECT_LT(share, 0.95) << name;
    // As much room on the one side as on the other, to a twentieth of the picture.
    EXPECT_NEAR(left, image->width - 1 - right, 0.05 * image->width) << name;
    EXPECT_NEAR(top, image->height - 1 - bottom, 0.05 * image->height) << name;
  }

  TemporaryFolder folder_;
};

/// A row of text per point of a sphere about `center`: x y z, its normal, and what `more` adds.
template <class More>
std::string sphere(int count, double center_x, double center_y, double center_z, bool normals,
                   const More& more) {
  std::ostringstream text;
  text.precision(12);
  for (int i = 0; i < count; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / count, r = std::sqrt(1.0 - z * z);
    const double angle = i * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double x = r * std::cos(angle), y = r * std::sin(angle);
    text << center_x + x << ' ' << center_y + y << ' ' << center_z + z;
    if (normals) text << ' ' << x << ' ' << y << ' ' << z;
    text << more(x, y, z) << '\n';
  }
  return text.str();
}

inline std::string ply(const std::string& comment, int count, const std::vector<std::string>& properties,
                       const std::string& rows) {
  std::string text = "ply\nformat ascii 1.0\n" + comment + "element vertex " + std::to_string(count) + "\n";
  for (const std::string& name : properties) text += "property float " + name + "\n";
  return text + "end_header\n" + rows;
}

inline std::string blender_ply() {
  return ply("comment Created in Blender version 4.0.2\n", 600,
             {"x", "y", "z", "nx", "ny", "nz", "velocity_x", "velocity_y", "velocity_z"},
             sphere(600, 0, 0, 1, true, [](double, double, double) { return " 4.8 0 0"; }));
}

inline void expect_said(const std::string& err, const std::vector<std::string>& lines) {
  for (const std::string& line : lines)
    EXPECT_NE(err.find(line), std::string::npos) << line << "\nin\n" << err;
}

}  // namespace swept::test
