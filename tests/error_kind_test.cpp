// Errors have a kind, for programs that have to decide what to do about them.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "splat/image.h"
#include "splat/io/image_file.h"
#include "splat/io/point_file.h"
#include "splat/io/scene_file.h"
#include "splat/io/sequence.h"
#include "splat/io/splat_file.h"
#include "temporary_folder.h"

namespace swept {
namespace {

template <class T>
ErrorKind kind_of(const Result<T>& result) {
  EXPECT_FALSE(result);
  return result ? ErrorKind::cancelled : result.error().kind;
}

class ErrorKinds : public testing::Test {
 protected:
  std::string file(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  test::TemporaryFolder folder_;
};

TEST_F(ErrorKinds, OfFilesThatAreNotThere) {
  EXPECT_EQ(kind_of(read_points(folder_ / "none.ply")), ErrorKind::not_found);
  EXPECT_EQ(kind_of(read_splats(folder_ / "none.spz")), ErrorKind::not_found);
  EXPECT_EQ(kind_of(read_scene_file(folder_ / "none.json")), ErrorKind::not_found);
  EXPECT_EQ(kind_of(read_exr(folder_ / "none.exr")), ErrorKind::not_found);
  EXPECT_EQ(kind_of(list_sequence(folder_ / "none.####.ply")), ErrorKind::not_found);
  EXPECT_EQ(kind_of(write_exr(folder_ / "no/folder/a.exr", blank_image({2, 2, 0, 0, 0, 0}))),
            ErrorKind::not_found);
}

TEST_F(ErrorKinds, OfFilesThatAreDamaged) {
  EXPECT_EQ(kind_of(read_points(file("a.ply", "ply\nformat ascii 1.0\n"))), ErrorKind::malformed);
  EXPECT_EQ(kind_of(read_points(file("a.xyz", "1 2 three\n"))), ErrorKind::malformed);
  EXPECT_EQ(kind_of(read_splats(file("a.splat", "short"))), ErrorKind::malformed);
  EXPECT_EQ(kind_of(read_scene_file(file("a.json", "{"))), ErrorKind::malformed);
  EXPECT_EQ(kind_of(read_scene_file(file("b.json", "{\"swept\": 1, \"film\": {\"width\": -3}}"))),
            ErrorKind::malformed);
  EXPECT_EQ(kind_of(read_exr(file("a.exr", "none"))), ErrorKind::malformed);
}

TEST_F(ErrorKinds, OfFilesThatSayTheyHoldNothing) {
  const std::string xyz = "property float x\nproperty float y\nproperty float z\n";
  EXPECT_EQ(
      kind_of(read_points(file("e.ply", "ply\nformat ascii 1.0\nelement vertex 0\n" + xyz + "end_header\n"))),
      ErrorKind::empty);
  EXPECT_EQ(
      kind_of(read_points(file("e.pcd",
                               "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\n"
                               "HEIGHT 1\nPOINTS 0\nDATA ascii\n"))),
      ErrorKind::empty);
  EXPECT_EQ(kind_of(read_points(file("e.off", "OFF\n0 0 0\n"))), ErrorKind::empty);
  // Formats that have no place to say so: the file may have been cut off.
  EXPECT_EQ(kind_of(read_points(file("e.xyz", ""))), ErrorKind::malformed);
  EXPECT_EQ(kind_of(read_points(file("e.obj", "# nothing\n"))), ErrorKind::malformed);
  EXPECT_EQ(kind_of(read_splats(file("e.splat", ""))), ErrorKind::malformed);
  // Nor is a file empty whose points are all left out.
  ReadOptions skip;
  skip.skip_invalid = true;
  EXPECT_EQ(kind_of(read_points(file("n.xyz", "nan 0 0\n"), skip)), ErrorKind::malformed);
}

TEST_F(ErrorKinds, OfWhatIsNotSupported) {
  EXPECT_EQ(kind_of(read_points(file("a.las", "LASF"))), ErrorKind::unsupported);
  EXPECT_EQ(kind_of(read_points(file("a.off", "OFF BINARY\n"))), ErrorKind::unsupported);
}

TEST_F(ErrorKinds, OfWrongArguments) {
  EXPECT_EQ(kind_of(blank_image({2, 2, 0, 0, 0, 0}).validate() ? Status(Error{"", "x", "y"}) : Done{}),
            ErrorKind::argument);
  Image image = blank_image({2, 2, 0, 0, 0, 0});
  image.rgba.pop_back();
  EXPECT_EQ(kind_of(write_exr(folder_ / "a.exr", image)), ErrorKind::argument);
  ReadOptions options;
  options.color_range = -1.0;
  EXPECT_EQ(kind_of(read_points(file("b.xyz", "1 2 3\n"), options)), ErrorKind::argument);
}

TEST_F(ErrorKinds, OfWhatCannotBeWritten) {
  EXPECT_EQ(kind_of(write_exr(folder_ / ".", blank_image({2, 2, 0, 0, 0, 0}))), ErrorKind::device);
}

TEST_F(ErrorKinds, HaveNames) {
  EXPECT_EQ(error_kind_name(ErrorKind::argument), "argument");
  EXPECT_EQ(error_kind_name(ErrorKind::out_of_memory), "out_of_memory");
  EXPECT_EQ(error_kind_name(ErrorKind::device), "device");
  EXPECT_EQ(error_kind_name(ErrorKind::empty), "empty");
}

}  // namespace
}  // namespace swept
