#include "splat/io/scene_splats.h"

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "splat/fields.h"
#include "splat/io/empty_files.h"
#include "splat/io/sequence.h"
#include "splat/io/source_files.h"

namespace swept::io {
namespace {

/// A member of the object that means nothing to splats; empty: there is none.
std::string disc_member(const ObjectSource& source, const Object& object) {
  const auto* file = std::get_if<FileSource>(&source.points);
  const auto& attributes =
      file != nullptr ? file->attributes : std::get<SequenceSource>(source.points).attributes;
  const StoredColor& stored = file != nullptr ? file->stored : std::get<SequenceSource>(source.points).stored;
  if (source.color || source.color_by_normals) return "color";
  if (source.radius) return "radius";
  if (source.radius_scale != 1.0) return "radius_scale";
  if (!object.two_sided || source.sideless) return "facing";
  if (!attributes.empty()) return "source/attributes";
  if (file != nullptr && !file->end_path.empty()) return "source/end_file";
  if (source.stamps) return "stamps";
  if (stored.range) return "source/color_range";
  if (stored.space) return "source/color_space";
  return {};
}

/// The file of a sequence that shows `scene.frame`, or the frame before it that there is one of.
Result<KeyFile> file_of_frame(const ObjectSource& source, const Scene& scene, std::string& note) {
  Result<SourceFiles> files = source_files(source, scene);
  if (!files) return Error{"", "source/" + files.error().field, files.error().reason, files.error().kind};
  note = std::move(files->note);
  KeyFile shown = files->files.front();
  for (const KeyFile& key : files->files)
    if (key.frame <= scene.frame) shown = key;
  return shown;
}

}  // namespace

bool draws_splats(const ObjectSource& source) {
  if (std::holds_alternative<GeneratorSource>(source.points) ||
      (source.draw && source.draw != DrawAs::splats))
    return false;
  if (source.draw == DrawAs::splats) return true;
  if (const auto* file = std::get_if<FileSource>(&source.points)) return holds_splats(file->path);
  const std::string& pattern = std::get<SequenceSource>(source.points).pattern;
  if (is_splat_file_name(pattern)) return true;
  const Result<std::vector<NumberedFile>> files = list_sequence(pattern);
  return files && !files->empty() && holds_splats(files->front().path);
}

Result<LoadedSplats> load_splats(const ObjectSource& source, const Object& object, const Scene& scene) {
  if (const std::string member = disc_member(source, object); !member.empty())
    return Error{"", member,
                 "means nothing to Gaussian splats; \"draw\": \"surfels\" has them read as discs"};
  SplatReadOptions options;
  KeyFile key;
  std::string note;
  if (const auto* file = std::get_if<FileSource>(&source.points)) {
    key = {file->frame, file->path};
    options.skip_invalid = file->skip_invalid;
    options.motion = true;
  } else {
    Result<KeyFile> shown = file_of_frame(source, scene, note);
    if (!shown) return shown.error();
    key = std::move(*shown);
  }
  Result<LoadedSplats> loaded = read_splats(key.path, options);
  if (!loaded && std::holds_alternative<SequenceSource>(source.points) &&
      loaded.error().kind == ErrorKind::empty) {
    LoadedSplats none;
    none.notes.push_back(empty_note(key.path) + ": there is nothing to draw of it");
    return none;
  }
  if (!loaded) return loaded;
  SplatCloud& splats = loaded->splats;
  splats.frame = key.frame;
  if (loaded->motion) {
    loaded->motion->frames = scene.splats.clip_frames;
    splats.motion = std::move(loaded->motion);
    loaded->motion.reset();
    loaded->report.assumed.push_back("splats move by themselves, over a clip of " +
                                     shortest_text(scene.splats.clip_frames) + " frames from frame " +
                                     shortest_text(key.frame) + " on, which no file says");
  }
  if (source.velocity == VelocityUnit::ignore) splats.velocity.clear();
  if (source.velocity == VelocityUnit::per_second)
    for (Eigen::Vector3f& velocity : splats.velocity)
      velocity = (velocity.cast<double>() * scene.fps.denominator / scene.fps.numerator).cast<float>();
  if (std::holds_alternative<SequenceSource>(source.points)) {
    if (!note.empty()) loaded->notes.push_back(note);
    loaded->notes.push_back(splats.velocity.empty()
                                ? "each frame shows its own file of splats, which stand still in it"
                                : "each frame shows its own file of splats, which move by their velocities");
  }
  return loaded;
}

}  // namespace swept::io
