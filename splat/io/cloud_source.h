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

/// How to read a single file of which each point was seen at a time of its own (model section 7).
struct TimeStamps {
  StampUnit unit = StampUnit::seconds;
  double zero = 0.0;  ///< the stamp of a point that was seen at the file's frame
  /// The pose of the sensor. Each point is placed and turned by the pose at its own time, and stays there. No
  /// keys: points are in the object's space, are at their place at their own time, and move by their own
  /// rates.
  TransformTrack sensor = {};
};

/// A pose of the cloud and the frame it is for.
struct KeyFile {
  double frame = 0.0;
  std::string path;
};

struct CloudSource {
  /// At strictly increasing frames. A single file may have velocities. Several files are keys of the same
  /// points, which are matched by id if the files have ids; else point i is point i in all of them.
  std::vector<KeyFile> files;
  std::map<std::string, std::string> attributes;  ///< as ReadOptions::attributes
  VelocityUnit velocity_unit = VelocityUnit::per_second;
  FrameRate fps;                         ///< turns velocities per second into velocities per frame
  std::optional<double> radius;          ///< every disc becomes round with this radius, object units, > 0
  double radius_scale = 1.0;             ///< multiplies whatever the radii are, > 0
  std::optional<Eigen::Vector3f> color;  ///< linear Rec.709, replaces the file's colours
  /// Colour as color_by_normals() does. Of estimated normals, whose side is not known, the side toward
  /// `normals_toward` is shown. Not together with `color`.
  bool color_by_normals = false;
  Eigen::Vector3d normals_toward = Eigen::Vector3d::UnitZ();  ///< object space, not zero
  bool skip_invalid = false;              ///< as ReadOptions::skip_invalid; single files only
  std::optional<double> color_range;      ///< as ReadOptions::color_range
  std::optional<ColorSpace> color_space;  ///< as ReadOptions::color_space
  double delta = 3.0;                     ///< δ of the kernel, for Gaussian files
  KeyPath path = KeyPath::linear;         ///< of several files
  std::optional<TimeStamps> stamps;       ///< of a single file
  bool texture = false;                   ///< as ReadOptions::texture
  /// The triangles of files that have them are to be drawn: a₁ × a₂ is along the file's normals, or, if there
  /// are none, along the mesh_normals() of each key.
  bool triangles = false;
  bool materials = false;  ///< as ReadOptions::materials
  /// true: a file that says it has no points (ErrorKind::empty) is a time at which there are none, as in a
  /// simulation before its first particles. The points of the file before it exist until halfway to it, those
  /// of the file after it from halfway on. false: such a file is an error.
  bool may_be_empty = false;
  /// For `triangles`, degrees in [0, 180]: triangles that meet at a greater angle do not share a normal, nor
  /// do triangles to whose corners the file gives different normals. Points are copied where that takes it.
  /// None: all triangles about a point share its normal. Not for sequences whose points come and go.
  std::optional<double> crease_angle;
};

/// A cloud that satisfies SurfelCloud::validate(), and what a person should know about how it was made.
struct LoadedCloud {
  SurfelCloud cloud;
  std::vector<Triangle> triangles;              ///< of meshes, between points of the cloud
  std::vector<TextureCorners> texture_corners;  ///< one a triangle, if asked for and in the file
  MaterialNames materials;                      ///< likewise
  std::string materials_of;                     ///< the path of the file that has the materials
  /// At creases points are copied; copy i is the point cloud.size() − copies.size() + i, of point copies[i].
  std::vector<std::uint32_t> copies;
  /// Of the first file read, until creases are found: whether it gives each point's normal, and the normals
  /// of corners.
  std::vector<std::uint8_t> smooth;
  std::vector<CornerNormals> corner_normals;
  std::vector<std::string> notes;  ///< with the file's path if there are several files
  /// Of the file whose colours the cloud has, with what had to be assumed to join several files.
  ReadReport report;
};

/// Colours every point by the normal n of its first key, as linear RGB (n + 1)/2, so that a cloud without
/// colours shows its shape. Errors: as SurfelCloud::validate(), or no key; the cloud is then unchanged.
[[nodiscard]] Status color_by_normals(SurfelCloud& cloud);

/// Reads the keys needed to know the cloud over frames [first, last]: the one at or before `first`, the one
/// at or after `last`, and those between. Axes come from the file; else from its triangles; else from the
/// nearest points. Discs are oriented where the first file read has a normal or triangles for them. Every
/// key's axes are aligned to those of the key before.
///
/// The reference file is the first file read if there are no ids; with ids it is the file nearest to the
/// middle of [first, last] (the earlier of two), and its points come first. The cloud's own colours and
/// opacities, and its triangles, are those of the reference file.
///
/// - Looks: colours and opacities that differ between the files read become looks; a file without them has
/// the
///   cloud's own. Colours by normals become looks if the normals turn by more than an 8-bit step over
///   [first, last]: at the keys, or as often as discs that spin need it.
/// - Ids: a point that not all files have exists from halfway after a file without it until halfway before
/// the
///   next. It has a lifetime if that is within [first, last]. There it moves along its velocity, or stands
///   still, and the report says so.
/// - Counts that differ, without ids: the cloud is the file nearest to the middle alone, if that has rates.
/// - Beyond the files: points move on along the rates of the file at that end, if it has any and is the
///   nearest to the middle; else they are held.
///
/// Errors: as read_points(); counts that differ in other cases; frames that do not increase; options out of
/// range.
[[nodiscard]] Result<LoadedCloud> read_cloud(const CloudSource& source, double first, double last);

/// The cloud, with a single key at `frame`, of points that are in memory. `source.files` is not used. Errors:
/// as PointSet::validate() and surfels_from_cloud(), a frame that is not finite, options out of range.
[[nodiscard]] Result<LoadedCloud> cloud_from_points(PointSet points, double frame, const CloudSource& source);

}  // namespace swept
