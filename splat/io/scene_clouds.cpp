// Loading the clouds that one frame of a scene file needs.
#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <new>
#include <utility>

#include "splat/io/guarded.h"
#include "splat/io/json_text.h"
#include "splat/io/mesh_creases.h"
#include "splat/io/obj_materials.h"
#include "splat/io/scene_clouds.h"
#include "splat/io/scene_splats.h"
#include "splat/io/source_files.h"
#include "splat/io/surfel_estimate.h"
#include "splat/io/texture_file.h"

namespace swept {
namespace {

/// Attributes that a generator does not know about.
Status apply_overrides(const ObjectSource& source, SurfelCloud& cloud) {
  if (source.velocity == VelocityUnit::ignore) {
    cloud.velocity.clear();
    cloud.acceleration.clear();
    cloud.angular_velocity.clear();
  }
  if (source.color) cloud.color.assign(cloud.size(), *source.color);
  if (source.color_by_normals) {
    if (Status s = color_by_normals(cloud); !s) return s;
  }
  if (!source.radius && source.radius_scale == 1.0) return Done{};
  for (SurfelKey& key : cloud.keys) {
    for (std::size_t i = 0; i < key.pose.size(); ++i) {
      Eigen::Vector3f &u = key.pose.axis_u[i], &v = key.pose.axis_v[i];
      const Eigen::Vector3d normal = u.cast<double>().cross(v.cast<double>());
      if (source.radius && !normal.isZero(0.0)) round_disc(normal, *source.radius, u, v);
      u = (u.cast<double>() * source.radius_scale).cast<float>();
      v = (v.cast<double>() * source.radius_scale).cast<float>();
    }
  }
  return Done{};
}

Result<LoadedCloud> generate_cloud(const GeneratorSource& points, const ObjectSource& source,
                                   double points_scale, const Generator& generator) {
  const double count = std::max(1.0, std::round(static_cast<double>(points.points) * points_scale));
  if (!(count < 1e15)) return Error{"", "points", "too many points"};
  Result<SurfelCloud> cloud = generator(points.shape, static_cast<std::size_t>(count), points.parameters);
  if (!cloud) return cloud.error();
  // The caller's generator may return anything.
  if (const Status valid = cloud->validate(); !valid) return valid.error();
  if (const Status applied = apply_overrides(source, *cloud); !applied) return applied.error();
  if (const Status valid = cloud->validate(); !valid) return valid.error();
  LoadedCloud loaded;
  loaded.cloud = std::move(*cloud);
  return loaded;
}

CloudSource cloud_source(const ObjectSource& source, const Scene& scene) {
  CloudSource cloud;
  cloud.velocity_unit = source.velocity;
  cloud.fps = scene.fps;
  cloud.radius = source.radius;
  cloud.radius_scale = source.radius_scale;
  cloud.color = source.color;
  cloud.color_by_normals = source.color_by_normals;
  cloud.normals_toward = source.normals_toward;
  cloud.delta = scene.model.delta;
  cloud.path = scene.motion.path;
  cloud.triangles = source.draw == DrawAs::triangles;
  cloud.materials = io::draws_materials(source);
  cloud.texture = source.draw == DrawAs::triangles && !source.texture.empty();
  cloud.crease_angle = source.crease_angle;
  cloud.stamps = source.stamps;
  return cloud;
}

}  // namespace

SceneFile::SceneFile() : clouds_(std::make_unique<Clouds>()) {}
SceneFile::SceneFile(SceneFile&&) noexcept = default;
SceneFile& SceneFile::operator=(SceneFile&&) noexcept = default;
SceneFile::~SceneFile() = default;

Error SceneFile::source_error(const ObjectSource& source, const Error& error) const {
  const std::string member = error.field.empty() ? "" : '/' + error.field;
  return {path_, source.pointer + "/source" + member, error.reason, in_a_file(error.kind)};
}

Result<LoadedCloud> SceneFile::load(const ObjectSource& source, const Scene& settings,
                                    const Generator& generator) const {
  const std::string pointer = source.pointer + "/source";
  if (const auto* points = std::get_if<GeneratorSource>(&source.points)) {
    Result<LoadedCloud> loaded = generate_cloud(*points, source, points_scale_, generator);
    if (!loaded)
      return Error{path_, io::join_pointer(pointer, loaded.error().field), loaded.error().reason,
                   in_a_file(loaded.error().kind)};
    return loaded;
  }
  CloudSource cloud = cloud_source(source, settings);
  const Exposure all = settings.exposure().of_all_rows(settings.film.height);
  double first = all.open, last = all.close;
  Result<io::SourceFiles> files = io::source_files(source, settings);
  if (!files) return source_error(source, files.error());
  cloud.files = std::move(files->files);
  if (const auto* file = std::get_if<FileSource>(&source.points)) {
    first = cloud.files.front().frame;
    last = cloud.files.back().frame;
    cloud.attributes = file->attributes;
    cloud.color_range = file->stored.range;
    cloud.color_space = file->stored.space;
    cloud.skip_invalid = file->skip_invalid;
  } else {
    const auto& sequence = std::get<SequenceSource>(source.points);
    cloud.attributes = sequence.attributes;
    cloud.may_be_empty = true;
    cloud.color_range = sequence.stored.range;
    cloud.color_space = sequence.stored.space;
  }
  Result<LoadedCloud> loaded = read_cloud(cloud, first, last);
  if (!loaded && loaded.error().file.empty())
    return Error{path_, pointer, Error{"", loaded.error().field, loaded.error().reason}.message(),
                 in_a_file(loaded.error().kind)};
  if (loaded && !files->note.empty()) loaded->notes.push_back(files->note);
  return loaded;
}

/// The picture is read once, and laid over all frames of a sequence.
Result<std::shared_ptr<const Texture>> SceneFile::load_texture(std::size_t i) const {
  if (scene_.objects[i].texture) return scene_.objects[i].texture;
  Result<Texture> texture = read_texture(sources_[i].texture);
  if (!texture) return texture.error();
  return std::make_shared<const Texture>(*std::move(texture));
}

Scene SceneFile::settings(double frame) const {
  Scene settings;
  settings.frame = frame;
  settings.film = scene_.film;
  settings.shutter = scene_.shutter;
  settings.fps = scene_.fps;
  settings.model = scene_.model;
  settings.motion = scene_.motion;
  settings.splats = scene_.splats;
  return settings;
}

/// With notes: splats where they are to be drawn as such, else a cloud.
Result<SceneFile::LoadedObject> SceneFile::load_object(std::size_t i, const Scene& settings,
                                                       const Generator& generator) const {
  const ObjectSource& source = sources_[i];
  LoadedObject object;
  std::vector<std::string>& notes = object.notes;
  // Without the file's name, so that the frames of a sequence do not all say the same again.
  const auto note = [&](std::vector<std::string> lines, const ReadReport& report) {
    notes = std::move(lines);
    for (std::string& line : report.lines()) notes.push_back(std::move(line));
  };
  if (source.draw == DrawAs::triangles && (source.radius || source.radius_scale != 1.0))
    return Error{path_, source.pointer + (source.radius ? "/radius" : "/radius_scale"),
                 "means nothing to triangles, which have no discs"};
  if (source.crease_angle && !io::creases_available())
    return Error{path_, source.pointer + "/crease_angle",
                 "this build was made without OpenMesh (-DSWEPT_OPENMESH=ON), which finds creases",
                 ErrorKind::unsupported};
  if (io::draws_splats(source)) {
    Result<LoadedSplats> loaded = io::load_splats(source, scene_.objects[i], settings);
    if (!loaded)
      return loaded.error().file.empty()
                 ? Error{path_, io::join_pointer(source.pointer, loaded.error().field), loaded.error().reason,
                         in_a_file(loaded.error().kind)}
                 : loaded.error();
    object.splats = std::move(loaded->splats);
    note(std::move(loaded->notes), loaded->report);
    return object;
  }
  Result<LoadedCloud> loaded = load(source, settings, generator);
  if (!loaded) return loaded.error();
  if (source.sideless) loaded->cloud.oriented.clear();
  if (!loaded->materials.names.empty() && !loaded->triangles.empty())
    if (Status taken = io::take_materials(source, *loaded, clouds_->materials[i], object.materials,
                                          object.material_of, object.texture_corners);
        !taken)
      return taken.error();
  object.cloud = std::move(loaded->cloud);
  if (source.draw == DrawAs::triangles && object.cloud.size() > 0) {
    if (loaded->triangles.empty())
      return Error{path_, source.pointer + "/draw", "the source holds no triangles to draw"};
    object.triangles = std::move(loaded->triangles);
    if (!source.texture.empty()) {
      if (loaded->texture_corners.empty())
        return Error{path_, source.pointer + "/texture", "the mesh has no texture coordinates",
                     ErrorKind::malformed};
      Result<std::shared_ptr<const Texture>> texture = load_texture(i);
      if (!texture) return texture.error();
      object.texture = *std::move(texture);
      object.texture_corners = std::move(loaded->texture_corners);
    }
  }
  note(std::move(loaded->notes), loaded->report);
  if (object.texture)
    notes.push_back("texture " + std::to_string(object.texture->width) + " x " +
                    std::to_string(object.texture->height) + ": " + source.texture);
  return object;
}

Result<const Scene*> SceneFile::scene_at(double frame, const Generator& generator) {
  return io::guarded(path_, [&]() -> Result<const Scene*> {
    if (!(std::abs(frame) <= most_frame))
      return Error{path_, "/frame", "the frame must be between -1e9 and 1e9"};
    scene_.frame = frame;
    clouds_->objects.resize(sources_.size());
    if (clouds_->ahead_frame != frame) clouds_->ahead.clear();
    for (std::size_t i = 0; i < sources_.size(); ++i) {
      Clouds::State& state = clouds_->objects[i];
      if (state.keep) continue;
      // Before the next one is read, so that two never share the memory.
      scene_.objects[i].cloud = {};
      scene_.objects[i].triangles = {};
      scene_.objects[i].texture_corners = {};
      scene_.objects[i].materials = {};
      scene_.objects[i].material_of = {};
      scene_.objects[i].splats = {};
      state.notes.clear();
      try {
        LoadedObject object;
        if (const auto ready = clouds_->ahead.find(i); ready != clouds_->ahead.end()) {
          object = std::move(ready->second);
          clouds_->ahead.erase(ready);
        } else {
          Result<LoadedObject> loaded = load_object(i, settings(frame), generator);
          if (!loaded) return loaded.error();
          object = *std::move(loaded);
        }
        scene_.objects[i].cloud = std::move(object.cloud);
        scene_.objects[i].triangles = std::move(object.triangles);
        scene_.objects[i].texture = std::move(object.texture);
        scene_.objects[i].texture_corners = std::move(object.texture_corners);
        scene_.objects[i].materials = std::move(object.materials);
        scene_.objects[i].material_of = std::move(object.material_of);
        scene_.objects[i].splats = std::move(object.splats);
        state.notes = std::move(object.notes);
        state.keep = !std::holds_alternative<SequenceSource>(sources_[i].points);
      } catch (const std::bad_alloc&) {
        return Error{path_, sources_[i].pointer + "/source", "not enough memory for its points",
                     ErrorKind::out_of_memory};
      } catch (const std::exception& exception) {
        return Error{path_, sources_[i].pointer + "/source", exception.what()};
      }
    }
    return &std::as_const(scene_);
  });
}

void SceneFile::load_ahead(double frame, const Generator& generator) noexcept {
  clouds_->ahead.clear();
  if (!(std::abs(frame) <= most_frame)) return;
  clouds_->ahead_frame = frame;
  for (std::size_t i = 0; i < sources_.size(); ++i) {
    if (!std::holds_alternative<SequenceSource>(sources_[i].points)) continue;
    try {
      Result<LoadedObject> loaded = load_object(i, settings(frame), generator);
      if (loaded) clouds_->ahead[i] = *std::move(loaded);
    } catch (...) {
      // There is no memory for two frames, or something else that scene_at() will find, too.
      clouds_->ahead.clear();
      return;
    }
  }
}

std::vector<std::string> SceneFile::notes() const {
  std::vector<std::string> notes = notes_;
  for (std::size_t i = 0; i < clouds_->objects.size(); ++i)
    for (const std::string& note : clouds_->objects[i].notes) {
      const std::string name = scene_.objects[i].name + ": ";
      notes.push_back(note.starts_with(name) ? note : name + note);
    }
  return notes;
}

}  // namespace swept
