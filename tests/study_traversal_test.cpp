// The study's tables of traversals: what is measured, and what is said of it.
#include "tools/study/traversal.h"

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/small_scenes.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

TEST(StudyTraversal, MeasuresTheScenesThatComeWithIt) {
  const test::TemporaryFolder folder;
  std::vector<TraversalRow> rows;
  for (const TraversalScene& scene : traversal_scenes(24, folder / "")) {
    if (scene.title == "Cloth ball" || scene.title == "Horse") continue;  // data that may not be here
    rows.push_back(measure_traversals(scene, 8, 1));
  }
  ASSERT_EQ(rows.size(), 3u);
  for (const TraversalRow& row : rows) {
    ASSERT_EQ(row.error, "") << row.title;
    EXPECT_GT(row.primitives, 100u);
    ASSERT_EQ(row.cells.size(), traversal_settings(8).size());
    for (const TraversalCell& cell : row.cells) {
      EXPECT_GT(cell.efficiency, 0.0);
      EXPECT_LE(cell.efficiency, 1.0);
      EXPECT_GT(cell.cpu_seconds, 0.0);
    }
    EXPECT_GT(row.cells[2].efficiency, row.cells[0].efficiency) << "tiles of 1 px and of 4 px";
  }
  const nlohmann::ordered_json json = to_json(rows);
  EXPECT_EQ(json["findings"].size(), 2u);
  EXPECT_EQ(json["rows"][0]["cells"]["tile-4"]["relative_time"], 1.0);
  EXPECT_EQ(json["rows"][0]["paper"]["interval-64"]["efficiency"], 0.18);
}

TraversalRow made_up(const char* title, double tile, double interval) {
  TraversalRow row;
  row.title = title;
  for (const TraversalSetting& setting : traversal_settings(1)) {
    const bool tiles = setting.options.traversal == Traversal::tile;
    const double rank = tiles ? 1.0 / setting.options.tile_px : setting.options.intervals / 100.0;
    row.cells.push_back({0.1 * rank + (tiles ? 0.5 : 0.1), (tiles ? tile : interval) * (1.0 + rank), 100.0});
  }
  return row;
}

TEST(StudyTraversal, SaysWhichFindingsHold) {
  TraversalRow failed = made_up("lost", 1.0, 1.0);
  failed.error = "no such file";
  const std::vector<std::string> findings =
      traversal_findings({made_up("walls", 1.0, 2.0), made_up("hair", 2.0, 1.0), failed});
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_NE(findings[0].find("on 2 of 2 scenes"), std::string::npos) << findings[0];
  EXPECT_NE(findings[1].find("tiles are faster on walls and the best intervals on hair,"), std::string::npos)
      << findings[1];
  EXPECT_NE(findings[1].find("take longer on 2 of 2"), std::string::npos) << findings[1];
}

TEST(StudyTraversal, SaysWhatItCannotDraw) {
  const test::TemporaryFolder folder;
  EXPECT_NE(traversal_scene("none", folder / "none.json", 24).error, "");
  TraversalScene splats{"splats", "", test::stage()};
  splats.scene.objects.emplace_back().splats.position.emplace_back(0, 0, 0);
  const TraversalRow row = measure_traversals(splats, 4, 1);
  EXPECT_NE(row.error.find("stochastic"), std::string::npos) << row.error;
  EXPECT_FALSE(to_json({row})["rows"][0]["error"].is_null());
  EXPECT_TRUE(to_json({row})["findings"].empty());
}

}  // namespace
}  // namespace swept
