// Sequences as farms name them: what is read at which frame, and what is said of it.
#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "splat/io/sequence.h"
#include "tests/scene_text.h"

namespace swept {
namespace {

using test::base_scene;
using test::base_source;
using test::dots;
using test::replaced;

class SequenceSources : public test::SceneFiles {
 protected:
  /// A triangle of which the first vertex is at (x, 0, 0).
  void put_file(const std::string& name, double x) const {
    write("v " + std::to_string(x) + " 0 0\nv 1 0 -4\nv 0 1 -4\nf 1 2 3\n", name);
  }

  static std::string name_of(std::string name, int number) {
    return name.append(std::to_string(number)).append(".obj");
  }

  SceneFile open(const std::string& source) const {
    Result<SceneFile> file = read_scene_file(write(replaced(base_scene, base_source, source)));
    EXPECT_TRUE(file.ok()) << file.error().message();
    if (!file.ok()) std::abort();  // nothing after it would make sense
    return std::move(*file);
  }

  /// Where the first point is at a frame.
  static double place(SceneFile& file, double frame) {
    const Result<const Scene*> scene = file.scene_at(frame, dots);
    EXPECT_TRUE(scene.ok()) << scene.error().message();
    return scene ? surfel_at((*scene)->objects[0].cloud, 0, frame).position.x() : NAN;
  }

  static bool noted(const SceneFile& file, const std::string& words) {
    const std::vector<std::string> notes = file.notes();
    return std::any_of(notes.begin(), notes.end(),
                       [&](const std::string& note) { return note.find(words) != note.npos; });
  }

  std::string error_of(const std::string& source) const {
    Result<SceneFile> file = read_scene_file(write(replaced(base_scene, base_source, source)));
    if (!file) return file.error().message();
    const Result<const Scene*> scene = file->scene_at(2.0, dots);
    return scene ? "" : scene.error().message();
  }
};

TEST_F(SequenceSources, StepsAndOffsets) {
  for (const int n : {1, 3, 5, 7}) put_file(name_of("s.000", n), n);
  for (const char* members : {R"("first": 1, "last": 7, "step": 2)", R"("frames": "1-7x2")",
                              R"("frames": "5,7,1-4x2")", R"("first": 1, "last": 8, "step": 2)"}) {
    for (const char* pattern : {"s.####.obj", "s.%04d.obj", "s.$F4.obj"}) {
      SceneFile file =
          open(std::string(R"({"sequence": ")") + pattern + "\", " + members + R"(, "offset": 10})");
      for (const auto& [frame, x] :
           {std::pair{11.0, 1.0}, {12.0, 2.0}, {14.5, 4.5}, {17.0, 7.0}, {30.0, 7.0}, {-5.0, 1.0}})
        EXPECT_EQ(place(file, frame), x) << pattern << members << frame;
      EXPECT_FALSE(noted(file, "its files are")) << "nothing was looked up";
    }
  }
  // A cycle of eight frames: half way from the last file to the first at frame 8.
  SceneFile cycle = open(R"({"sequence": "s.####.obj", "first": 1, "last": 7, "step": 2, "cycle": true})");
  for (const auto& [frame, x] :
       {std::pair{8.0, 4.0}, {9.0, 1.0}, {11.0, 3.0}, {1.0 - 800.0, 1.0}, {-1.0, 7.0}, {0.0, 4.0}})
    EXPECT_EQ(place(cycle, frame), x) << frame;
}

TEST_F(SequenceSources, WhatIsOnDiskIsTakenAndSaid) {
  for (const int n : {1, 2, 4, 5, 9}) put_file(name_of("g", n), n);
  SceneFile file = open(R"({"sequence": "g#.obj"})");
  EXPECT_EQ(place(file, 3.0), 3.0) << "straight across the gap";
  EXPECT_EQ(place(file, 6.0), 6.0);
  EXPECT_TRUE(noted(file, "its files are 1-2,4-5,9"));

  SceneFile gaps = open(R"({"sequence": "g#.obj", "first": 1, "last": 5, "gaps": true})");
  EXPECT_EQ(place(gaps, 3.0), 3.0);
  EXPECT_EQ(place(gaps, 7.0), 5.0) << "9 is not among them";
  EXPECT_TRUE(noted(gaps, "its files are 1-2,4-5"));
  EXPECT_NE(error_of(R"({"sequence": "g#.obj", "first": 1, "last": 5})").find("there is no file"),
            std::string::npos);
  EXPECT_NE(error_of(R"({"sequence": "g#.obj", "first": 20, "last": 25, "gaps": true})").find("none of"),
            std::string::npos);
  EXPECT_NE(error_of(R"({"sequence": "none#.obj"})").find("no such file"), std::string::npos);
}

TEST_F(SequenceSources, MayBeginBelowZeroInBothSpellings) {
  put_file("a.-002.obj", -2);
  put_file("a.-001.obj", -1);
  put_file("a.0000.obj", 0);
  put_file("b.-0002.obj", -2);
  put_file("b.-0001.obj", -1);
  put_file("b.0000.obj", 0);
  for (const char* name : {"a", "b"}) {
    for (const char* members : {"", R"(, "first": -2, "last": 0)", R"(, "frames": "-2-0")"}) {
      SceneFile file = open(std::string(R"({"sequence": ")") + name + ".####.obj\"" + members + "}");
      EXPECT_EQ(place(file, -1.5), -1.5) << name << members;
    }
  }
  put_file("b.-001.obj", -1);
  EXPECT_NE(error_of(R"({"sequence": "b.####.obj"})").find("both"), std::string::npos);
}

TEST_F(SequenceSources, ContradictionsAreErrors) {
  for (const auto& [source, part] :
       {std::pair{R"({"sequence": "s#.obj", "frames": "1-3", "first": 1})", "/first: goes without"},
        {R"({"sequence": "s#.obj", "frames": "3-1"})", "/frames: the range"},
        {R"({"sequence": "s#.obj", "first": 1})", "\"last\" is missing"},
        {R"({"sequence": "s#.obj", "step": 2})", "/step: goes with"},
        {R"({"sequence": "s#.obj", "first": 1, "last": 9, "step": 0})", "/step: must be between"},
        {R"({"sequence": "s#.obj", "first": 1, "last": 9, "offset": 1e10})", "/offset: must be between"},
        {R"({"sequence": "s#.obj", "first": 1, "last": 9, "stpe": 2})", "did you mean \"step\"?"}})
    EXPECT_NE(error_of(source).find(part), std::string::npos) << source << error_of(source);
}

TEST(SequenceNames, OnlyTheFilesOwnNameHasThem) {
  EXPECT_EQ(*sequence_path("run#1/100%_%03d.ply", 7), "run#1/100%_007.ply");
  EXPECT_EQ(*sequence_path("a/$F.ply", 12), "a/12.ply");
  EXPECT_EQ(*sequence_path("a/w.$F4.ply", 12), "a/w.0012.ply");
  for (const char* none : {"a#/b.ply", "%04d/b.ply", "100%.exr", "a$FF.ply", "$HIP.ply"}) {
    EXPECT_FALSE(sequence_path(none, 1).ok()) << none;
    EXPECT_FALSE(is_sequence_pattern(none)) << none;
  }
  EXPECT_FALSE(sequence_path("##.$F.ply", 1).ok());
}

TEST(FrameRanges, AreSaidAsTheyAreRead) {
  for (const char* text : {"5", "1-3", "-3--1", "1-9x2", "1-3,7", "1,4,6-8", "1-2,4-5,9", "1-7x3,20-40x10"})
    EXPECT_EQ(frame_ranges_text(*parse_frame_ranges(text)), text);
}

}  // namespace
}  // namespace swept
