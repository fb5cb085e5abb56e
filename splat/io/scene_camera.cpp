#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "splat/io/scene_parsing.h"

namespace swept::io {
namespace {

double parse_fov(const JsonNode& node, const Film& film) {
  node.expect_keys({"axis", "degrees"});
  const std::size_t axis = node.require("axis").one_of({"vertical", "horizontal", "diagonal"});
  const JsonNode degrees = node.require("degrees");
  const double value = degrees.number();
  if (!(value > 0.0 && value < 180.0)) degrees.fail("must be above 0 and below 180");
  const double width = film.width, height = film.height;
  const double extent = axis == 0 ? height : axis == 1 ? width : std::hypot(width, height);
  return std::tan(0.5 * value * std::numbers::pi / 180.0) * height / extent;
}

/// How wide a camera or key sees, and where its view direction meets the film.
struct View {
  double tan_half_fov_y = 0.5;
  Lens lens;
  bool orthographic = false;
};

/// Focal lengths and principal point in pixels of a picture of `width` × `height`. A film of another size
/// shows the same height of it, in pixels of the same shape.
View parse_intrinsics(const JsonNode& node) {
  node.expect_keys({"width", "height", "fx", "fy", "cx", "cy"});
  const double width = node.require("width").positive(), height = node.require("height").positive();
  const JsonNode fx = node.require("fx");
  const double focal_x = fx.positive();
  double focal_y = focal_x;
  if (const auto fy = node.find("fy")) focal_y = fy->positive();
  View view;
  view.tan_half_fov_y = 0.5 * height / focal_y;
  view.lens.stretch_x = focal_x / focal_y;
  if (const auto cx = node.find("cx")) view.lens.shift.x() = (cx->number() - 0.5 * width) / height;
  if (const auto cy = node.find("cy")) view.lens.shift.y() = (cy->number() - 0.5 * height) / height;
  if (!(view.tan_half_fov_y > 0.0) || !std::isfinite(view.tan_half_fov_y)) fx.fail("is no focal length");
  return view;
}

/// "fov", "intrinsics" or "height" of `node`, if it has one of them.
std::optional<View> parse_view(const JsonNode& node, const Film& film) {
  const auto fov = node.find("fov"), intrinsics = node.find("intrinsics"), height = node.find("height");
  if (height && (fov || intrinsics))
    height->fail("is what an orthographic camera sees, and there is a field of view beside it");
  if (height) return View{0.5 * height->positive(), {}, true};
  if (fov && intrinsics) intrinsics->fail("there is \"fov\" beside it, and one of the two says it all");
  if (fov) return View{parse_fov(*fov, film), {}};
  if (intrinsics) return parse_intrinsics(*intrinsics);
  return std::nullopt;
}

/// Of "lens", the opening; its "focus" is each key's that has none of its own.
Aperture parse_aperture(const JsonNode& node) {
  node.expect_keys({"aperture", "f_number", "focal_length", "focus", "blades", "rotation", "samples"});
  Aperture aperture;
  const auto diameter = node.find("aperture"), number = node.find("f_number"),
             focal = node.find("focal_length");
  if (diameter.has_value() == number.has_value())
    node.fail("a lens has either \"aperture\", its diameter, or \"f_number\" with \"focal_length\"");
  if (diameter) {
    if (focal) focal->fail("goes with \"f_number\"");
    if (!((aperture.radius = 0.5 * diameter->number()) >= 0.0)) diameter->fail("must be 0 or more");
  } else {
    if (!focal) number->fail("goes with \"focal_length\", in world units");
    aperture.radius = 0.5 * focal->positive() / number->positive();
  }
  if (const auto blades = node.find("blades")) aperture.blades = static_cast<int>(blades->integer(3, 64));
  if (const auto rotation = node.find("rotation"))
    aperture.rotation_radians = rotation->number() * std::numbers::pi / 180.0;
  if (const auto samples = node.find("samples"))
    aperture.samples = static_cast<int>(samples->integer(1, 4096));
  return aperture;
}

LookAtKey parse_look_at(const JsonNode& node) {
  LookAtKey key;
  key.eye = node.require("eye").vector3();
  key.target = node.require("target").vector3();
  if (const auto up = node.find("up")) key.up = up->vector3();
  if (const auto roll = node.find("roll")) key.roll_radians = roll->number() * std::numbers::pi / 180.0;
  return key;
}

/// Row by row, or as four rows.
std::vector<double> matrix_numbers(const JsonNode& node) {
  const std::vector<JsonNode> rows = node.elements();
  if (rows.empty() || !rows.front().is_array()) return node.numbers(16);
  if (rows.size() != 4) node.fail("expected 4 rows, found " + std::to_string(rows.size()));
  std::vector<double> numbers;
  for (const JsonNode& row : rows)
    for (const double number : row.numbers(4)) numbers.push_back(number);
  return numbers;
}

CameraKey parse_matrix(const JsonNode& node, bool opengl) {
  using RowMajor = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
  const std::vector<double> numbers = matrix_numbers(node);
  const RowMajor matrix = Eigen::Map<const RowMajor>(numbers.data());
  // Four decimal digits must pass: entries off by 5e-5 put a product of two columns off by 3 · 1e-4.
  constexpr double rigid_tolerance = 3e-4;
  // What is inverted or multiplied elsewhere comes with rounding in the last row too.
  if (!((matrix.row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() <= rigid_tolerance))
    node.fail("the last row of the camera-to-world matrix must be 0 0 0 1");
  const Eigen::Matrix3d linear = matrix.topLeftCorner<3, 3>();
  const Eigen::Matrix3d deviation = linear.transpose() * linear - Eigen::Matrix3d::Identity();
  if (!(deviation.cwiseAbs().maxCoeff() <= rigid_tolerance))
    node.fail("the camera-to-world matrix is not rigid: it is singular, scales or shears");
  if (linear.determinant() < 0.0) node.fail("the camera-to-world matrix mirrors");
  // The nearest rotation, so that rounding in the file does not shear the image.
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(linear, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  if (opengl) rotation.rightCols<2>() *= -1.0;
  CameraKey key;
  key.eye = matrix.topRightCorner<3, 1>();
  key.world_from_camera = Eigen::Quaterniond(rotation).normalized();
  return key;
}

}  // namespace

double parse_key_frame(const JsonNode& key, std::size_t i, std::size_t count, double previous) {
  if (count == 1 && !key.find("frame")) return 0.0;
  const JsonNode node = key.require("frame");
  const double frame = node.number();
  if (i > 0 && !(previous < frame)) node.fail("keys must be at strictly increasing frames");
  return frame;
}

CameraTrack parse_camera(const JsonNode& node, const Film& film) {
  node.expect_keys({"fov", "intrinsics", "height", "near", "lens", "keys", "convention"});
  CameraTrack camera;
  if (const auto near = node.find("near")) camera.near = near->positive();
  const auto lens = node.find("lens");
  std::optional<double> common_focus;
  if (lens) {
    camera.aperture = parse_aperture(*lens);
    if (const auto focus = lens->find("focus")) common_focus = focus->positive();
  }
  bool opengl = true;
  if (const auto convention = node.find("convention")) opengl = convention->one_of({"opengl", "opencv"}) == 0;
  const std::optional<View> common_view = parse_view(node, film);

  const JsonNode list = node.require("keys");
  const std::vector<JsonNode> keys = list.elements();
  if (keys.empty()) list.fail("a camera needs at least one key");
  const bool matrices = keys.front().find("matrix").has_value();
  double previous = 0.0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const JsonNode& key = keys[i];
    key.expect_keys(
        {"frame", "eye", "target", "up", "roll", "matrix", "fov", "intrinsics", "height", "focus"});
    if (key.find("matrix").has_value() != matrices)
      key.fail("the keys of a camera must be all look-ats or all matrices");
    previous = parse_key_frame(key, i, keys.size(), previous);
    const std::optional<View> own_view = parse_view(key, film);
    if (!own_view && !common_view)
      key.fail("no field of view: neither the key nor the camera has \"fov\", \"intrinsics\" or \"height\"");
    View view = own_view ? *own_view : *common_view;
    if (i == 0) camera.orthographic = view.orthographic;
    if (view.orthographic != camera.orthographic)
      key.fail("the keys of a camera must all have a \"height\", as of an orthographic one, or none");
    const auto own_focus = key.find("focus");
    if (own_focus && !lens) own_focus->fail("goes with a \"lens\" of the camera");
    if (own_focus)
      view.lens.focus = own_focus->positive();
    else if (common_focus)
      view.lens.focus = *common_focus;
    else if (lens && matrices)
      key.fail("a lens needs \"focus\", the distance that is in focus, in the key or in the lens");
    if (matrices) {
      for (const char* look_at : {"eye", "target", "up", "roll"})
        if (const auto member = key.find(look_at)) member->fail("a key with a matrix has no look-at");
      camera.poses.push_back(parse_matrix(key.require("matrix"), opengl));
      camera.poses.back().frame = previous;
      camera.poses.back().tan_half_fov_y = view.tan_half_fov_y;
      camera.poses.back().lens = view.lens;
    } else {
      camera.look_ats.push_back(parse_look_at(key));
      camera.look_ats.back().frame = previous;
      camera.look_ats.back().tan_half_fov_y = view.tan_half_fov_y;
      // What a camera looks at is what it is focused on.
      if (lens && view.lens.focus == 0.0)
        view.lens.focus = (camera.look_ats.back().target - camera.look_ats.back().eye).norm();
      camera.look_ats.back().lens = view.lens;
    }
  }
  if (const auto convention = node.find("convention"); convention && !matrices)
    convention->fail("a convention of axes goes with matrix keys, and these are look-ats");
  return camera;
}

}  // namespace swept::io
