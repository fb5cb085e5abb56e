// Loading the clouds that one frame of a scene file needs.
#include <algorithm>
#include <cmath>
#include <exception>
#include <filesystem>
#include <utility>

#include "splat/io/json_text.h"
#include "splat/io/scene_file.h"
#include "splat/io/sequence.h"
#include "splat/io/surfel_estimate.h"

namespace swept {
namespace {

constexpr double max_files_per_shutter = 10'000.0;

Status require_files(const CloudSource& source, const std::string& scene, const std::string& pointer) {
  std::error_code code;
  for (const KeyFile& key : source.files)
    if (!std::filesystem::exists(key.path, code))
      return Error{scene, pointer, "there is no file " + key.path};
  return Done{};
}

/// Attributes that a generator does not know about.
void apply_overrides(const ObjectSource& source, SurfelCloud& cloud) {
  if (source.velocity == VelocityUnit::ignore) cloud.velocity.clear();
  if (source.color) cloud.color.assign(cloud.size(), *source.color);
  if (source.color_by_normals) color_by_normals(cloud);
  if (!source.radius && source.radius_scale == 1.0) return;
  for (SurfelKey& key : cloud.keys) {
    for (std::size_t i = 0; i < key.pose.size(); ++i) {
      Eigen::Vector3f &u = key.pose.axis_u[i], &v = key.pose.axis_v[i];
      const Eigen::Vector3d normal = u.cast<double>().cross(v.cast<double>());
      if (source.radius && !normal.isZero(0.0)) round_disc(normal, *source.radius, u, v);
      u = (u.cast<double>() * source.radius_scale).cast<float>();
      v = (v.cast<double>() * source.radius_scale).cast<float>();
    }
  }
}

Result<LoadedCloud> generate_cloud(const GeneratorSource& points, const ObjectSource& source,
                                   double points_scale, const Generator& generator) {
  const double count = std::max(1.0, std::round(static_cast<double>(points.points) * points_scale));
  if (!(count < 1e15)) return Error{"", "points", "too many points"};
  Result<SurfelCloud> cloud = generator(points.shape, static_cast<std::size_t>(count), points.parameters);
  if (!cloud) return cloud.error();
  apply_overrides(source, *cloud);
  if (const Status valid = cloud->validate(); !valid) return valid.error();
  return LoadedCloud{std::move(*cloud), {}, {}};
}

/// The files around [first, last]: at or before, at or after, and those between.
Result<std::vector<KeyFile>> files_around(const SequenceSource& sequence, double first, double last) {
  double low = std::floor(first), high = std::ceil(last);
  if (!sequence.cycle) {
    low = std::clamp<double>(low, sequence.first, sequence.last);
    high = std::clamp<double>(high, sequence.first, sequence.last);
  }
  if (high - low >= max_files_per_shutter)
    return Error{"", "sequence", "the shutter is open over more than 10000 files"};
  const double period = 1.0 + sequence.last - sequence.first;
  std::vector<KeyFile> files;
  for (double frame = low; frame <= high; frame += 1.0) {
    const double phase = std::fmod(frame - sequence.first, period);
    const int number = sequence.first + static_cast<int>(phase < 0.0 ? phase + period : phase);
    Result<std::string> path = sequence_path(sequence.pattern, number);
    if (!path) return Error{"", "sequence", path.error().reason};
    files.push_back({frame, std::move(*path)});
  }
  return files;
}

CloudSource cloud_source(const ObjectSource& source, const Scene& scene) {
  CloudSource cloud;
  cloud.velocity_unit = source.velocity;
  cloud.fps = scene.fps;
  cloud.radius = source.radius;
  cloud.radius_scale = source.radius_scale;
  cloud.color = source.color;
  cloud.color_by_normals = source.color_by_normals;
  cloud.delta = scene.model.delta;
  return cloud;
}

}  // namespace

/// What is known of the clouds that the scene's objects hold at the moment.
struct SceneFile::Clouds {
  struct State {
    bool keep = false;  ///< loaded, and the same at every frame
    std::vector<std::string> notes;
  };
  std::vector<State> objects;
};

SceneFile::SceneFile() : clouds_(std::make_unique<Clouds>()) {}
SceneFile::SceneFile(SceneFile&&) noexcept = default;
SceneFile& SceneFile::operator=(SceneFile&&) noexcept = default;
SceneFile::~SceneFile() = default;

Result<LoadedCloud> SceneFile::load(const ObjectSource& source, const Generator& generator) const {
  const std::string pointer = source.pointer + "/source";
  if (const auto* points = std::get_if<GeneratorSource>(&source.points)) {
    Result<LoadedCloud> loaded = generate_cloud(*points, source, points_scale_, generator);
    if (!loaded) return Error{path_, io::join_pointer(pointer, loaded.error().field), loaded.error().reason};
    return loaded;
  }
  CloudSource cloud = cloud_source(source, scene_);
  double first = scene_.frame + scene_.shutter.open, last = scene_.frame + scene_.shutter.close;
  std::string member = "/file";
  if (const auto* file = std::get_if<FileSource>(&source.points)) {
    cloud.files.push_back({file->frame, file->path});
    first = last = file->frame;
    if (!file->end_path.empty()) {
      cloud.files.push_back({file->end_frame, file->end_path});
      last = file->end_frame;
      member = "";
    }
    cloud.attributes = file->attributes;
    cloud.color_range = file->stored.range;
    cloud.color_space = file->stored.space;
    cloud.skip_invalid = file->skip_invalid;
  } else {
    const auto& sequence = std::get<SequenceSource>(source.points);
    Result<std::vector<KeyFile>> files = files_around(sequence, first, last);
    member = "/sequence";
    if (!files) return Error{path_, pointer + member, files.error().reason};
    cloud.files = std::move(*files);
    cloud.attributes = sequence.attributes;
    cloud.color_range = sequence.stored.range;
    cloud.color_space = sequence.stored.space;
  }
  if (const Status status = require_files(cloud, path_, pointer + member); !status) return status.error();
  Result<LoadedCloud> loaded = read_cloud(cloud, first, last);
  if (!loaded && loaded.error().file.empty())
    return Error{path_, pointer, Error{"", loaded.error().field, loaded.error().reason}.message()};
  return loaded;
}

Result<const Scene*> SceneFile::scene_at(double frame, const Generator& generator) {
  if (!std::isfinite(frame)) return Error{path_, "/frame", "the frame is not a finite number"};
  scene_.frame = frame;
  clouds_->objects.resize(sources_.size());
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    Clouds::State& state = clouds_->objects[i];
    if (state.keep) continue;
    // Before the next one is read, so that two never share the memory.
    scene_.objects[i].cloud = {};
    state.notes.clear();
    try {
      Result<LoadedCloud> loaded = load(sources_[i], generator);
      if (!loaded) return loaded.error();
      scene_.objects[i].cloud = std::move(loaded->cloud);
      state.notes = std::move(loaded->notes);
      // Without the file's name, so that the frames of a sequence do not all say the same again.
      for (std::string& line : loaded->report.lines()) state.notes.push_back(std::move(line));
      state.keep = !std::holds_alternative<SequenceSource>(sources_[i].points);
    } catch (const std::bad_alloc&) {
      return Error{path_, sources_[i].pointer + "/source", "not enough memory for its points"};
    }
  }
  return &std::as_const(scene_);
}

std::vector<std::string> SceneFile::notes() const {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < clouds_->objects.size(); ++i)
    for (const std::string& note : clouds_->objects[i].notes)
      notes.push_back(scene_.objects[i].name + ": " + note);
  return notes;
}

}  // namespace swept
