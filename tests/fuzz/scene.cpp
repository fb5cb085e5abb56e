// Fuzzes scene files: whatever the text, it is refused with a reason or is a scene that renders. Points come
// from the generators and from the few files of scene_points/; a scene that names any other file is read and
// goes no further.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <string_view>

#include "abuffer/abuffer.h"
#include "datasets/generators.h"
#include "splat/io/scene_file.h"
#include "tests/fuzz/check.h"

namespace swept {
namespace {

const std::string folder = SWEPT_SCENE_FOLDER;
const std::string path = folder + "/scene.json";

bool in_folder(const std::string& file) { return std::filesystem::path(file).parent_path() == folder; }

/// Few points, and files of the folder.
bool may_load(const ObjectSource& source) {
  if (const auto* generator = std::get_if<GeneratorSource>(&source.points)) return generator->points <= 100;
  if (const auto* file = std::get_if<FileSource>(&source.points))
    return in_folder(file->path) && (file->end_path.empty() || in_folder(file->end_path));
  return in_folder(std::get<SequenceSource>(source.points).pattern);
}

void check_image(const Image& image) {
  for (std::size_t i = 0; i < image.rgba.size(); ++i) SWEPT_HOLDS(std::isfinite(image.rgba[i]));
  for (const float depth : image.depth) SWEPT_HOLDS(depth > 0.0f);
}

void load_and_render(SceneFile file) {
  const Result<const Scene*> scene = file.scene_at(file.scene().frame, generate);
  if (!scene) {
    SWEPT_HOLDS(!scene.error().reason.empty());
    return;
  }
  for (const Object& object : (*scene)->objects)
    if (std::max(object.segments, (*scene)->model.segments) > 8) return;
  const Result<Rendered> rendered = render_abuffer(**scene, {}, {.threads = 1});
  // What a file says was found valid; what can still be wrong is what it leads to together with its clouds.
  if (rendered)
    check_image(rendered->image);
  else
    SWEPT_HOLDS(!rendered.error().reason.empty());
}

}  // namespace
}  // namespace swept

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace swept;
  const std::string text(reinterpret_cast<const char*>(data), size);
  SceneOverrides small;
  small.fields = {{"/film/width", {4}}, {"/film/height", {3}}};
  Result<SceneFile> file = scene_from_text(text, path, small);
  if (!file) {
    fuzz::check_error(file.error(), path.c_str());
    return 0;
  }
  // The files it names may be anywhere; without them it is all the file's own.
  const auto named = [](const ObjectSource& source) {
    return !std::holds_alternative<GeneratorSource>(source.points);
  };
  if (std::none_of(file->sources().begin(), file->sources().end(), named)) {
    const Result<std::string> hash = file->hash(file->scene().frame);
    SWEPT_HOLDS(hash.ok() && hash->size() == 16);
  }
  if (file->sources().size() <= 4 && std::all_of(file->sources().begin(), file->sources().end(), may_load))
    load_and_render(*std::move(file));
  return 0;
}
