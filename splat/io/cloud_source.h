// From point files to a moving cloud: one pose, one pose with velocities, or a sequence of poses.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/io/point_file.h"
#include "splat/result.h"
#include "splat/scene.h"
#include "splat/surfel.h"

namespace SWEPT_API swept {

/// What a file's velocities are measured in; files do not say.
enum class VelocityUnit { per_second, per_frame, ignore };

/// What the time stamps of a file's points are measured in.
enum class StampUnit { seconds, frames };

/// How points of a single file that were each seen at a time of their own are read (model section 7).
struct TimeStamps {
  StampUnit unit = StampUnit::seconds;
  double zero = 0.0;  ///< the stamp of a point that was seen at the file's frame
  /// Where the sensor was: each point stands where this has it at its own time, and stays there; and turned
  /// likewise. None: points are in the object's space, and move there by their own rates from their own time
  /// on.
  TransformTrack sensor = {};
};

/// A pose of the cloud and the frame it is for.
struct KeyFile {
  double frame = 0.0;
  std::string path;
};

struct CloudSource {
  /// At strictly increasing frames. One file may carry velocities. Several are keys of the same points:
  /// matched by id where the files have ids, else point i is point i in all of them.
  std::vector<KeyFile> files;
  std::map<std::string, std::string> attributes;  ///< as ReadOptions::attributes
  VelocityUnit velocity_unit = VelocityUnit::per_second;
  FrameRate fps;                         ///< turns velocities per second into velocities per frame
  std::optional<double> radius;          ///< every disc becomes round with this radius, object units, > 0
  double radius_scale = 1.0;             ///< multiplies whatever the radii are, > 0
  std::optional<Eigen::Vector3f> color;  ///< linear Rec.709, replaces the file's colours
  /// As color_by_normals(), but of estimated normals, whose side is not known, the side toward
  /// `normals_toward`; not together with `color`.
  bool color_by_normals = false;
  Eigen::Vector3d normals_toward = Eigen::Vector3d::UnitZ();  ///< the side of normals that are estimated
  bool skip_invalid = false;              ///< as ReadOptions::skip_invalid; single files only
  std::optional<double> color_range;      ///< as ReadOptions::color_range
  std::optional<ColorSpace> color_space;  ///< as ReadOptions::color_space
  double delta = 3.0;                     ///< δ of the kernel, for Gaussian files
  KeyPath path = KeyPath::linear;         ///< of several files
  std::optional<TimeStamps> stamps;       ///< of a single file
  bool texture = false;                   ///< as ReadOptions::texture
  /// Triangles are to be drawn, of files that have them: a₁ × a₂ is along the normals that the file gives,
  /// and else along mesh_normals() of each key.
  bool triangles = false;
  bool materials = false;  ///< as ReadOptions::materials
  /// A file that says it has no points (ErrorKind::empty) is a time at which there are none, as in a
  /// simulation before its first particles: those of the files beside it exist until, and from, halfway to
  /// it. Else it is an error.
  bool may_be_empty = false;
  /// Of `triangles`: those that meet at a greater angle, degrees, do not share a normal, nor do those whose
  /// corners the file gives different ones; points become several where that takes it. [0, 180]; none: all
  /// triangles about a point share its normal. Not of sequences whose points come and go.
  std::optional<double> crease_angle;
};

/// A cloud that satisfies SurfelCloud::validate(), and what a person should know about how it came about.
struct LoadedCloud {
  SurfelCloud cloud;
  std::vector<Triangle> triangles;              ///< of meshes, between points of the cloud
  std::vector<TextureCorners> texture_corners;  ///< one a triangle, if they were asked for and are there
  MaterialNames materials;                      ///< likewise, with the path of the file that has them
  std::string materials_of;
  std::vector<std::uint32_t> copies;  ///< what the last points are copies of, at creases
  /// Of the first file read, until creases are found: whether it gives a point's normal, and those of
  /// corners.
  std::vector<std::uint8_t> smooth;
  std::vector<CornerNormals> corner_normals;
  std::vector<std::string> notes;  ///< with the file's path where there are several
  ReadReport report;  ///< of the file whose colours the cloud has, with what joining several had to assume
};

/// Colours every point by its first key's normal n, (n + 1)/2 as linear RGB: shape to look at where a file
/// has none. Errors: as SurfelCloud::validate(), or no key; the cloud is then as it was.
[[nodiscard]] Status color_by_normals(SurfelCloud& cloud);

/// Reads the keys needed to know the cloud over frames [first, last]: the one at or before `first`, the one
/// at or after `last`, and those between. Axes come from the file; else from its triangles; else from the
/// nearest points. Discs are oriented where the first file read has a normal or triangles for them. Every
/// key's axes are aligned to those of the key before.
///
/// Colours by normals that turn by more than an 8-bit step over [first, last] are looks, at the keys, or as
/// often as discs that spin need it. Colours and opacities that differ between the files read are looks, of
/// all of them. A file without them has those of the cloud's own, which, as triangles, are those of the first
/// file read if there are no ids. With ids, they are those of the file nearest to the middle of [first, last]
/// (the earlier of two), whose points come first. A point that not all files have exists from halfway after a
/// file without it until halfway before the next: lifetimes, if that is within [first, last]; it moves there
/// along its velocity, or stands still, which is told in the report. If counts differ and there are no ids,
/// the cloud is that nearest file alone, if it has rates. Where [first, last] reaches beyond the files,
/// points move on along the rates of the file at that end, if it has any and is that nearest one; else they
/// are held.
///
/// Errors: as read_points, counts that differ between files otherwise, frames that do not increase, options
/// out of range.
[[nodiscard]] Result<LoadedCloud> read_cloud(const CloudSource& source, double first, double last);

/// The single-key cloud of points already in memory, at `frame`. `source.files` is not looked at. Errors: as
/// PointSet::validate(), as surfels_from_cloud(), a frame that is not finite, options out of range.
[[nodiscard]] Result<LoadedCloud> cloud_from_points(PointSet points, double frame, const CloudSource& source);

}  // namespace swept
