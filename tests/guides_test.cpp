// What the README and the guides say to type does run, on small files of the same names, and their links lead
// somewhere.
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/io/image_file.h"
#include "tests/cloud_files.h"
#include "tests/packed_bytes.h"
#include "tests/point_files.h"

namespace swept {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::Outcome;
using test::ply;
using test::put;
using test::run_command;
using test::sphere;
using Guides = test::CloudCommandFolder;

const fs::path project = SWEPT_PROJECT;

std::vector<fs::path> pages() {
  std::vector<fs::path> paths{project / "README.md", project / "CONTRIBUTING.md",
                              project / "datasets" / "README.md"};
  for (const auto& entry : fs::directory_iterator(project / "tools" / "guides"))
    paths.push_back(entry.path());
  return paths;
}

/// Lines between fences that begin with a command, without what a comment says of them.
std::vector<std::string> commands_of(const fs::path& page) {
  std::istringstream text(content_of(page));
  std::vector<std::string> commands;
  bool fenced = false;
  for (std::string line; std::getline(text, line);) {
    if (line.starts_with("```")) fenced = !fenced;
    if (!fenced || !(line.starts_with("swept ") || line.find("tools/farm/") != std::string::npos)) continue;
    line = line.substr(0, line.find(" # "));
    line.erase(line.find_last_not_of(' ') + 1);
    commands.push_back(line);
  }
  return commands;
}

std::string numbered(int i) {
  const std::string digits = std::to_string(i);
  return std::string(4 - digits.size(), '0') + digits;
}

/// A plane of 24 points with whole coordinates, of no directions.
std::string survey() {
  std::string text = "Easting,Northing,Elevation,Intensity\n";
  for (int i = 0; i < 400; ++i)
    text += std::to_string(512345.25 + 0.25 * (i % 20)) + ',' + std::to_string(5412345.75 + 0.25 * (i / 20)) +
            ",310.5," + std::to_string(i % 200) + '\n';
  return text;
}

/// Three splats of the second version, whose streams are places, opacities, colours, scales and rotations.
std::string spz() {
  using namespace swept_test;
  std::string bytes = "NGSP" + le32(2) + le32(3) + std::string("\0\x0c\0\0", 4);
  for (int i = 0; i < 9; ++i)
    bytes += le32(static_cast<std::size_t>(400 * (i % 3) + 900 * (i / 3))).substr(0, 3);
  return gzip(bytes + std::string(3, '\xff') + std::string(9, '\xa0') + std::string(9, '\x80') +
              std::string(9, '\x7f'));
}

/// Splats as SpacetimeGaussians' lite model stores them.
std::string moving_splats() {
  std::vector<std::string> names = {"x",      "y",      "z",       "trbf_center", "trbf_scale", "f_dc_0",
                                    "f_dc_1", "f_dc_2", "opacity", "scale_0",     "scale_1",    "scale_2",
                                    "rot_0",  "rot_1",  "rot_2",   "rot_3"};
  for (int i = 0; i < 9; ++i) names.push_back("motion_" + std::to_string(i));
  for (int i = 0; i < 4; ++i) names.push_back("omega_" + std::to_string(i));
  std::vector<std::vector<double>> rows;
  for (int i = 0; i < 4; ++i) {
    std::vector<double> row(names.size(), 0.0);
    row[0] = i - 1.5;
    row[1] = i % 2;
    row[8] = 2.0;
    row[9] = row[10] = row[11] = -2.0;
    row[12] = row[16] = 1.0;
    rows.push_back(row);
  }
  return swept_test::float_ply("binary_little_endian", names, rows);
}

std::string tetrahedron(double moved) {
  std::ostringstream text;
  for (const char* vertex : {"0 0", "1 0", "0 1", "1 1"}) text << "v " << moved << ' ' << vertex << '\n';
  return text.str() + "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nf 1/1 2/2 4/4\nf 1/1 4/4 3/3\n";
}

std::string path() {
  std::string frames;
  for (int i = 0; i < 48; ++i)
    frames += std::string(i == 0 ? "" : ",") + R"({"camera_to_world": [1,0,0,)" + std::to_string(0.01 * i) +
              R"(, 0,1,0,0, 0,0,1,4, 0,0,0,1], "fov": 50, "aspect": 1.7})";
  return R"({"camera_type": "perspective", "render_height": 18, "render_width": 32, "fps": 24, "seconds": 2,
    "camera_path": [)" +
         frames + "]}";
}

/// All files that the pages name, small.
void put_files(const test::TemporaryFolder& folder) {
  const auto none = [](double, double, double) { return ""; };
  const std::string cloud = ply("", 200, {"x", "y", "z"}, sphere(200, 0, 0, 0, false, none));
  put(folder / "cloud.ply", cloud);
  put(folder / "blender.ply", test::blender_ply());
  for (int i = 1; i <= 48; ++i) {
    const std::string moved = ply("", 100, {"x", "y", "z"}, sphere(100, 0.01 * i, 0, 0, false, none));
    for (const char* name : {"anim.", "sparks.", "particles."})
      put(folder / (name + numbered(i) + ".ply"), moved);
  }
  for (const char* name : {"sparse_pc.ply", "scan.ply"}) put(folder / name, cloud);
  put(folder / "transforms.json",
      R"({"camera_angle_x": 0.8, "w": 32, "h": 18, "frames": [
        {"file_path": "a.png", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,8],[0,0,0,1]]},
        {"file_path": "b.png", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,5],[0,0,0,1]]}]})");
  put(folder / "scan.pcd",
      "VERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 200\nHEIGHT 1\n"
      "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 200\nDATA ascii\n" +
          sphere(200, 10, 2, 0, false, [](double, double, double z) { return z > 0 ? " 40" : " 20"; }));
  put(folder / "survey.txt", survey());
  put(folder / "scene.spz", spz());
  put(folder / "path.json", path());
  put(folder / "dynamic.ply", moving_splats());
  put(folder / "mesh.obj", tetrahedron(0.0));
  put(folder / "wall.obj", tetrahedron(0.0));
  fs::create_directory(folder / "gallop");
  for (int i = 1; i <= 3; ++i) put(folder / ("gallop/" + numbered(i) + ".obj"), tetrahedron(0.02 * i));
  fs::create_directory(folder / "datasets");
  for (const char* name : {"dandelion.json", "dandelion.splat", "pinwheel.obj"})
    fs::copy(project / "datasets" / name, folder / "datasets");
  fs::copy(project / "tools" / "farm", folder / "tools/farm", fs::copy_options::recursive);
}

/// Options that make a command of the pages quick, and let it run beside the others.
std::string small(const std::string& command) {
  const auto has = [&](const char* option) { return command.find(option) != std::string::npos; };
  if (command.starts_with("swept study"))
    return std::string(" --quick --size 32x18 --repeats 1 --reference-samples 8 --points-scale 0.01") +
           (has("--parts") ? "" : " --methods sampled");
  if (command.starts_with("tools/farm/")) return " --size 32x18";
  if (command.starts_with("swept init")) return " --overwrite";
  if (!command.starts_with("swept render")) return "";
  return std::string(has("--camera") ? "" : " --size 32x18") + (has("--skip-existing") ? "" : " --overwrite");
}

TEST_F(Guides, CommandsRunAsTheyStand) {
  fs::create_directory(folder_ / "tools");
  put_files(folder_);
  const std::string in_folder = "cd '" + (folder_ / "") + "' && export PATH='" +
                                fs::path(SWEPT_COMMAND).parent_path().string() + "':\"$PATH\" && ";
  const auto run = [&](const std::string& command) { return run_command("(" + in_folder + command + ")"); };
  for (const char* prepared : {"swept render cloud.ply -o truth.exr --size 32x18",
                               "swept init cloud.ply -o scene.json", "swept init cloud.ply -o shot.json",
                               "swept render scene.json -o mine.exr --size 32x18 --preview wood.png"}) {
    const Outcome outcome = run(prepared);
    ASSERT_EQ(outcome.exit_code, 0) << prepared << '\n' << outcome.err;
  }
  const bool parallel = run_command("command -v parallel").exit_code == 0;
  std::set<std::string> seen, left_out;
  for (const fs::path& page : pages())
    for (std::string command : commands_of(page)) {
      if (!seen.insert(command).second) continue;
      const std::string as_written = page.filename().string() + ": " + command;
      // Half a minute by itself; visibility_test and study_traversal_test run what is in it.
      if (command.find("visibility,ronnow,hierarchy") != std::string::npos ||
          // Slurm is on no machine that tests run on, and farm_test plays it.
          command.find("sbatch") != std::string::npos ||
          (command.starts_with("tools/farm/gnu-parallel") && !parallel)) {
        left_out.insert(as_written);
        continue;
      }
      command += small(command);
      const std::size_t part = command.find("part.03.exr --part 3/16");
      for (int i = 1; i <= (part == std::string::npos ? 1 : 16); ++i) {
        std::string one = command;
        if (part != std::string::npos)
          one.replace(part, 23, "part." + numbered(i).substr(2) + ".exr --part " + std::to_string(i) + "/16");
        const Outcome outcome = run(one);
        EXPECT_EQ(outcome.exit_code, 0) << as_written << '\n' << outcome.err;
      }
    }
  EXPECT_EQ(left_out.size(), parallel ? 2u : 3u);
  EXPECT_GE(seen.size(), 30u);  // as many as there are, so that a page that lost its fences is seen
}

/// As pages of repositories make anchors of headings: small letters, spaces as hyphens, no other signs.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char c : heading) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' || c == '_' || (c & 0x80) != 0)
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (c == ' ') anchor += '-';
  }
  return anchor;
}

std::set<std::string> anchors_of(const fs::path& page) {
  std::istringstream text(content_of(page));
  std::set<std::string> anchors;
  for (std::string line; std::getline(text, line);)
    if (line.starts_with("#")) anchors.insert(anchor_of(line.substr(line.find_first_not_of("# "))));
  return anchors;
}

TEST(GuidesText, LinksLeadSomewhere) {
  int links = 0;
  for (const fs::path& page : pages()) {
    const std::string text = content_of(page);
    for (std::size_t at = text.find("]("); at != std::string::npos; at = text.find("](", at + 1)) {
      const std::string link = text.substr(at + 2, text.find(')', at) - at - 2);
      if (link.starts_with("http")) continue;
      ++links;
      const std::string file = link.substr(0, link.find('#'));
      const fs::path target = file.empty() ? page : page.parent_path() / file;
      EXPECT_TRUE(fs::exists(target)) << page << ": " << link;
      if (link.find('#') != std::string::npos) {
        EXPECT_TRUE(anchors_of(target).contains(link.substr(link.find('#') + 1))) << page << ": " << link;
      }
    }
  }
  EXPECT_GE(links, 30);
}

TEST(GuidesText, TheReadmeIsShortAndNamesEveryGuide) {
  const std::string readme = content_of(project / "README.md");
  EXPECT_LE(std::count(readme.begin(), readme.end(), '\n'), 200);
  for (const auto& entry : fs::directory_iterator(project / "tools" / "guides"))
    EXPECT_NE(readme.find("(tools/guides/" + entry.path().filename().string() + ")"), std::string::npos)
        << entry.path();
}

}  // namespace
}  // namespace swept
