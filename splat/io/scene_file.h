// Scene files, version 1 (datasets/README.md describes the format): one JSON file that names film, camera,
// shutter and objects, and the clouds it refers to.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "splat/export.h"
#include "splat/fields.h"
#include "splat/io/cloud_source.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// Makes the cloud of `{"generator": shape, "points": points, parameter: number}`, velocities per frame.
/// The error's field is the member at fault.
using Generator = std::function<Result<SurfelCloud>(const std::string& shape, std::size_t points,
                                                    const std::map<std::string, double>& parameters)>;

struct GeneratorSource {
  std::string shape;
  std::size_t points = 0;
  std::map<std::string, double> parameters;  ///< "seed" is one of them
};

/// How files store colours; what is not given is read from their own numbers.
struct StoredColor {
  std::optional<double> range;      ///< as ReadOptions::color_range
  std::optional<ColorSpace> space;  ///< as ReadOptions::color_space
};

struct FileSource {
  std::string path;
  double frame = 0.0;                             ///< the frame at which points are where the file says
  std::map<std::string, std::string> attributes;  ///< as CloudSource::attributes
  StoredColor stored;
  bool skip_invalid = false;  ///< drop points that are not finite; else an error
  std::string end_path;       ///< the same points at end_frame; empty: none
  double end_frame = 1.0;
};

/// File n holds the points at frame n + offset.
struct SequenceSource {
  std::string pattern;             ///< with %04d, #### or $F4
  std::optional<int> first, last;  ///< numbers of files; both or none
  int step = 1;                    ///< from one number to the next, ≥ 1
  std::vector<int> numbers;        ///< increasing; instead of the three above
  int offset = 0;
  bool gaps = false;   ///< files may be missing, and points move straight across; false: that is an error
  bool cycle = false;  ///< frame last + step is frame first again, in both directions; false: held outside
  std::map<std::string, std::string> attributes;
  StoredColor stored;
};

/// What a file's splats, points or meshes are drawn as.
enum class DrawAs { splats, surfels, triangles };

/// Where an object's points come from, and what is done to them before they are rendered.
struct ObjectSource {
  std::variant<GeneratorSource, FileSource, SequenceSource> points;
  std::string pointer;  ///< JSON pointer of the object, for messages
  /// None: as splats if a single file holds trained ones, else as surfels.
  std::optional<DrawAs> draw;
  std::string texture;                 ///< path of a picture for the triangles; empty: none
  std::optional<double> crease_angle;  ///< as CloudSource::crease_angle
  VelocityUnit velocity = VelocityUnit::per_second;
  std::optional<TimeStamps> stamps;                           ///< of a single file
  std::optional<Eigen::Vector3f> color;                       ///< linear; replaces the source's
  bool color_by_normals = false;                              ///< likewise, from each disc's normal
  Eigen::Vector3d normals_toward = Eigen::Vector3d::UnitZ();  ///< the side of normals that are estimated
  bool sideless = false;         ///< normals may point either way: no disc is oriented
  std::optional<double> radius;  ///< object units; discs become round
  double radius_scale = 1.0;
};

/// What a caller sets of the camera in place of what a file says, whichever file the camera comes from.
struct CameraOverrides {
  /// Makes the camera orthographic, with a film of this height, world units. 0: the height that look-ats see
  /// at their targets.
  std::optional<double> height;
  bool no_lens = false;                          ///< everything is in focus
  std::optional<double> aperture;                ///< the lens's diameter, world units
  std::optional<double> f_number, focal_length;  ///< or the diameter as focal_length / f_number, world units
  struct Focus {
    double frame, distance;
  };
  std::vector<Focus> focus;                ///< keys of the depth in focus; a single one holds at any frame
  std::optional<int> blades, lens_points;  ///< as in Aperture
  std::optional<double> rotation_degrees;

  [[nodiscard]] bool any() const;
  /// All of the above, for hashes.
  [[nodiscard]] std::vector<double> numbers() const;
};

/// What a caller sets in place of what the file says.
struct SceneOverrides {
  /// By the pointers of splat/fields.h, as in {"/film/width", {640}}. "/image/segments" is for all objects,
  /// including those that name their own.
  FieldValues fields;
  std::optional<DrawAs> draw;  ///< for all objects that have files
  std::string texture;         ///< for all objects that are drawn as triangles; empty: as the file says
  std::optional<double> crease_angle;  ///< likewise
  double points_scale = 1.0;           ///< multiplies the point counts of generated objects; > 0
  /// Cameras of nerfstudio, instant-ngp, COLMAP or glTF, in place of the scene's camera; empty: none.
  std::string camera_file;
  CameraOverrides camera;
  /// For every key of a look-at camera, and for the view of points that come without a scene; not zero.
  std::optional<Eigen::Vector3d> up;
};

/// A scene file that was read and found valid. Clouds are loaded frame by frame.
class SceneFile {
 public:
  SceneFile(SceneFile&&) noexcept;
  SceneFile& operator=(SceneFile&&) noexcept;
  ~SceneFile();

  /// Everything but the clouds, which are empty until scene_at() loads them. Scene::frame is the frame that
  /// the file itself asks for.
  [[nodiscard]] const Scene& scene() const { return scene_; }
  [[nodiscard]] const std::vector<ObjectSource>& sources() const { return sources_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  /// JSON pointers of the members that the file itself has, and how many there are of each. That is 1, except
  /// for arrays called "keys", which count their elements, and for members of these, which are counted with
  /// the index "*": "/camera/keys/*/focus". Of other arrays only "objects" is listed element by element.
  [[nodiscard]] const std::map<std::string, std::size_t>& members() const { return members_; }

  /// The scene with the clouds that the shutter at `frame` sees. Generated clouds and single files are loaded
  /// once and kept; of a sequence only the files around the shutter are kept. The scene belongs to this
  /// object, and changes with the next call. Errors: files that cannot be read or do not fit the scene.
  [[nodiscard]] Result<const Scene*> scene_at(double frame, const Generator& generator);

  /// Loads what scene_at(frame) will need, and keeps it for that call; what was loaded ahead for another
  /// frame is dropped. It is meant for another thread while a scene is rendered: it does not change the
  /// scene, but must not run at the same time as hash() or any function of this object that is not const. An
  /// error here occurs again in scene_at(), and is returned there. Does nothing if nothing is loaded frame by
  /// frame.
  void load_ahead(double frame, const Generator& generator) noexcept;

  /// Generates the clouds that scene_at(frame) will need, several objects at once on `threads` threads (0:
  /// all), and keeps them for that call. All threads call `generator` at once. An error here occurs again in
  /// scene_at(), and is returned there.
  void generate_ahead(double frame, const Generator& generator, int threads) noexcept;

  /// What the scene assumes, and what the readers of the clouds of the last scene_at() read, did not read,
  /// and had to assume, e.g. estimated normals.
  [[nodiscard]] std::vector<std::string> notes() const;

  /// A hash of all that the picture of `frame` depends on, except for the method: the file's content without
  /// its layout, the overrides, the frame, and size and content of the files that scene_at(frame) reads.
  /// FNV-1a, 64 bits, 16 hexadecimal digits. Errors: files that cannot be read.
  [[nodiscard]] Result<std::string> hash(double frame) const;
  /// hash() of the same picture without a crop.
  [[nodiscard]] Result<std::string> whole_hash(double frame) const;

 private:
  struct Clouds;
  friend Result<SceneFile> scene_from_text(const std::string& text, const std::string& path,
                                           const SceneOverrides& overrides, std::vector<std::string> notes);
  SceneFile();
  struct LoadedObject;
  /// What does not depend on the clouds, at `frame`: all that loading them needs.
  [[nodiscard]] Scene settings(double frame) const;
  [[nodiscard]] Result<LoadedObject> load_object(std::size_t i, const Scene& settings,
                                                 const Generator& generator) const;
  [[nodiscard]] Result<std::shared_ptr<const Texture>> load_texture(std::size_t i) const;
  [[nodiscard]] Result<LoadedCloud> load(const ObjectSource& source, const Scene& settings,
                                         const Generator& generator) const;
  [[nodiscard]] Result<std::string> hash_of(double frame, const std::string& canonical) const;
  /// An error of source_files(), seen from the scene file.
  [[nodiscard]] Error source_error(const ObjectSource& source, const Error& error) const;

  std::string path_, canonical_, canonical_whole_;
  std::vector<std::string> notes_;
  std::map<std::string, std::size_t> members_;
  Scene scene_;
  std::vector<ObjectSource> sources_;
  double points_scale_ = 1.0;
  std::unique_ptr<Clouds> clouds_;
};

/// Reads and validates a scene file, but none of the clouds it names. Paths in it are relative to its folder.
/// Errors name the file, a JSON pointer (line and column for bad syntax) and the reason; those about an
/// override name the option's member in the scene.
[[nodiscard]] Result<SceneFile> read_scene_file(const std::string& path,
                                                const SceneOverrides& overrides = {});

/// The same for a scene file's text, as if it stood in the file `path`, which is not looked at.
/// SceneFile::notes() begins with `notes`.
[[nodiscard]] Result<SceneFile> scene_from_text(const std::string& text, const std::string& path,
                                                const SceneOverrides& overrides = {},
                                                std::vector<std::string> notes = {});

/// The fields of splat/fields.h as they are in `scene`, as a scene file has them: one JSON object, indented.
/// What is unset is left out.
[[nodiscard]] std::string fields_to_text(const Scene& scene);

}  // namespace swept
