// Images in and out: OpenEXR for numbers, PNG for eyes.
//
// Every file is written under a temporary name in its own folder and renamed once it is complete. The same
// image and metadata give the same bytes.
#pragma once

#include <string>

#include <Eigen/Core>

#include "splat/camera.h"
#include "splat/deep_image.h"
#include "splat/export.h"
#include "splat/image.h"
#include "splat/io/atomic_file.h"
#include "splat/result.h"

namespace SWEPT_API swept {

/// How the image was made, for readers of the file. It is written to the EXR header as:
///
///   framesPerSecond  rational        fps_numerator / fps_denominator
///   expTime          float           exposure_seconds
///   shutterAngle     float, degrees  360 · (shutter_close − shutter_open)
///   shutterOpen, shutterClose  double, frames relative to the frame
///   worldToCamera    m44f            world_to_camera in OpenEXR's terms: points are row vectors,
///                                    p_camera = p_world · M, and camera axes x right, y up, z forward
///   worldToNDC       m44f            p_world · M, divided by its w, is (0, 0) in the upper left corner of
///                                    the display window and (1, 1) in the lower right; z is 1 − near/depth
///   screenWindowCenter v2f           the film's middle at depth 1, from the view direction, y up
///   screenWindowWidth float          the film's width at depth 1; of an orthographic camera, at any depth
///   pixelAspectRatio float           1 / lens.stretch_x
///   fieldOfView      float, degrees  along the film's width; not of an orthographic camera
///   sceneHash, method, software  string  left out if empty
///   wholeHash        string          likewise; of a crop, the sceneHash that the whole film has
///
/// in addition to the compression (ZIP), the windows and the Rec.709 chromaticities. Without a field of view
/// there is no worldToNDC and no fieldOfView. A float has 7 digits: a point a million units from the origin
/// is placed to 0.1 units.
struct ImageMetadata {
  int fps_numerator = 24, fps_denominator = 1;     ///< both > 0
  double exposure_seconds = 0.0;                   ///< how long the shutter is open, ≥ 0
  double shutter_open = 0.0, shutter_close = 0.0;  ///< frames relative to the frame
  /// For column vectors, mid-shutter; camera axes x right, y down, z forward, as everywhere in Swept.
  Eigen::Matrix4d world_to_camera = Eigen::Matrix4d::Identity();
  double tan_half_fov_y = 0.0;  ///< of the whole film, mid-shutter; 0: not known
  Lens lens{};                  ///< mid-shutter
  bool orthographic = false;    ///< as CameraInstant has it, and tan_half_fov_y with it
  double near = 1e-3;           ///< world units, > 0
  std::string scene_hash, whole_hash;
  std::string method;  ///< how the image was computed, with the options that change it
  std::string software;
};

enum class ExrPixels {
  float32,  ///< the image's own bits
  float16,  ///< R G B A as half, rounded to nearest and infinite beyond 65504; all else stays float32
};

/// Writes R G B A, linear and premultiplied, Z if `image.depth` is not empty, and `image.channels` as float.
/// The display window is the film, the data window the image's window of it. Errors: sizes that do not fit
/// each other (the field names the array), metadata out of range, and what the file system objects to.
[[nodiscard]] Status write_exr(const std::string& path, const Image& image,
                               const ImageMetadata& metadata = {}, ExrPixels pixels = ExrPixels::float32,
                               IfExists existing = IfExists::replace);

/// Writes a deep image as scan lines: R G B A, Z and ZBack of every sample. The header is that of
/// write_exr(), with compression ZIPS and the string deepSamples, which says what a sample means. Errors: as
/// write_exr().
[[nodiscard]] Status write_deep_exr(const std::string& path, const DeepImage& image,
                                    const ImageMetadata& metadata = {}, ExrPixels pixels = ExrPixels::float32,
                                    IfExists existing = IfExists::replace);

/// Reads R, G, B and, where present, A and Z of the first part: scan lines or tiles, half, float or uint.
/// Without A the image is opaque (1); without Z `depth` is empty. Other channels are not read. The film is
/// the display window, and the image's window is relative to it, so x and y are negative in a file with
/// overscan.
///
/// Errors: missing, truncated and corrupt files, files without R, G or B, and windows of more pixels than
/// the file's size can hold, whatever its header says.
[[nodiscard]] Result<Image> read_exr(const std::string& path);

/// The part of ImageMetadata that tells one picture from another.
struct ExrOrigin {
  std::string scene_hash, method;  ///< empty: the file does not say
};

/// Reads only the header of an EXR. Errors: those of read_exr() that can be seen without reading the pixels,
/// and blocks of pixels that are missing or beyond the file's end.
[[nodiscard]] Result<ExrOrigin> read_exr_origin(const std::string& path);

/// An image with the window and film that read_exr() would return, from the header alone; the arrays are
/// empty. Errors: those of read_exr() that the header shows.
[[nodiscard]] Result<Image> read_exr_window(const std::string& path);

/// Writes an 8-bit RGBA preview of the window: colours divided by alpha, clipped to [0, 1], by the sRGB
/// curve. A pixel whose alpha is 0, or that has a NaN, is 0. Errors: as write_exr().
[[nodiscard]] Status write_png(const std::string& path, const Image& image,
                               IfExists existing = IfExists::replace);

}  // namespace swept
