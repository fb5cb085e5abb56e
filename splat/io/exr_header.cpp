#include "splat/io/exr_header.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <ImathMatrix.h>
#include <ImfChromaticities.h>
#include <ImfCompression.h>
#include <ImfDoubleAttribute.h>
#include <ImfFloatAttribute.h>
#include <ImfRational.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

namespace swept {
namespace {

/// For row vectors.
Imath::M44f row_matrix(const Eigen::Matrix4d& matrix) {
  Imath::M44f transposed;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      transposed[column][row] = static_cast<float>(matrix(row, column));
  return transposed;
}

void add_camera(Imf::Header& header, const ExrWindow& image, const ImageMetadata& metadata) {
  const Eigen::Vector4d y_up(1.0, -1.0, 1.0, 1.0);
  Imf::addWorldToCamera(header, row_matrix(y_up.asDiagonal() * metadata.world_to_camera));
  if (metadata.tan_half_fov_y == 0.0) return;
  const Lens& lens = metadata.lens;
  const double height = 2.0 * metadata.tan_half_fov_y;
  const double aspect = static_cast<double>(image.film_width) / image.film_height;
  const double width = height * aspect / lens.stretch_x;
  Eigen::Matrix4d ndc_from_camera;  // axes as in Swept; w is the depth
  ndc_from_camera << 1.0 / width, 0.0, 0.5 + lens.shift.x() / aspect, 0.0,  //
      0.0, 1.0 / height, 0.5 + lens.shift.y(), 0.0,                         //
      0.0, 0.0, 1.0, -metadata.near,                                        //
      0.0, 0.0, 1.0, 0.0;
  // Parallel rays divide by nothing.
  if (metadata.orthographic)
    ndc_from_camera << 1.0 / width, 0.0, 0.0, 0.5 + lens.shift.x() / aspect,  //
        0.0, 1.0 / height, 0.0, 0.5 + lens.shift.y(),                         //
        0.0, 0.0, 1.0, -metadata.near,                                        //
        0.0, 0.0, 0.0, 1.0;
  Imf::addWorldToNDC(header, row_matrix(ndc_from_camera * metadata.world_to_camera));
  header.screenWindowWidth() = static_cast<float>(width);
  // The film's middle from the principal point, y up. Adding zero leaves no −0 in the file.
  const double middle_x = 0.0 - lens.shift.x() / aspect * width, middle_y = lens.shift.y() * height + 0.0;
  header.screenWindowCenter() = Imath::V2f(static_cast<float>(middle_x), static_cast<float>(middle_y));
  // Focal lengths differ in px because pixels do in length.
  header.pixelAspectRatio() = static_cast<float>(1.0 / lens.stretch_x);
  if (metadata.orthographic) return;
  constexpr double degrees = 180.0 / std::numbers::pi;
  const double fov = std::atan(middle_x + 0.5 * width) - std::atan(middle_x - 0.5 * width);
  header.insert("fieldOfView", Imf::FloatAttribute(static_cast<float>(fov * degrees)));
}

}  // namespace

Status check(const ImageMetadata& metadata) {
  if (metadata.fps_numerator <= 0 || metadata.fps_denominator <= 0) {
    return Error{"", "fps", "must be a positive fraction"};
  }
  if (!std::isfinite(metadata.exposure_seconds) || metadata.exposure_seconds < 0) {
    return Error{"", "exposure_seconds", "must be finite and not negative"};
  }
  if (!std::isfinite(metadata.shutter_open) || !std::isfinite(metadata.shutter_close) ||
      metadata.shutter_open > metadata.shutter_close) {
    return Error{"", "shutter", "must be finite and not close before it opens"};
  }
  if (!metadata.world_to_camera.allFinite()) return Error{"", "world_to_camera", "must be finite"};
  if (!(metadata.tan_half_fov_y >= 0.0) || !std::isfinite(metadata.tan_half_fov_y))
    return Error{"", "tan_half_fov_y", "must be finite and not negative"};
  if (!(metadata.lens.stretch_x > 0.0) || !std::isfinite(metadata.lens.stretch_x) ||
      !metadata.lens.shift.allFinite())
    return Error{"", "lens", "must be finite, and the stretch above 0"};
  if (!(metadata.near > 0.0) || !std::isfinite(metadata.near)) return Error{"", "near", "must be above 0"};
  return Done{};
}

Imf::Header header_of(const ExrWindow& image, const ImageMetadata& metadata) {
  using Imath::Box2i;
  using Imath::V2i;
  const Box2i display(V2i(0, 0), V2i(image.film_width - 1, image.film_height - 1));
  const Box2i data(V2i(image.x, image.y), V2i(image.x + image.width - 1, image.y + image.height - 1));
  Imf::Header header(display, data, 1.0f, Imath::V2f(0.0f, 0.0f), 1.0f, Imf::INCREASING_Y,
                     Imf::ZIP_COMPRESSION);
  Imf::addChromaticities(header, Imf::Chromaticities());  // the default is Rec.709 with D65
  Imf::addFramesPerSecond(
      header, Imf::Rational(metadata.fps_numerator, static_cast<unsigned>(metadata.fps_denominator)));
  Imf::addExpTime(header, static_cast<float>(metadata.exposure_seconds));
  header.insert(
      "shutterAngle",
      Imf::FloatAttribute(static_cast<float>(360.0 * (metadata.shutter_close - metadata.shutter_open))));
  header.insert("shutterOpen", Imf::DoubleAttribute(metadata.shutter_open));
  header.insert("shutterClose", Imf::DoubleAttribute(metadata.shutter_close));
  add_camera(header, image, metadata);
  for (const auto& [name, text] : {std::pair{"sceneHash", &metadata.scene_hash},
                                   {"wholeHash", &metadata.whole_hash},
                                   {"method", &metadata.method},
                                   {"software", &metadata.software}})
    if (!text->empty()) header.insert(name, Imf::StringAttribute(*text));
  return header;
}

}  // namespace swept
