#include "splat/io/scene_inputs.h"

#include <utility>

#include "splat/io/guarded.h"
#include "splat/io/obj_materials.h"
#include "splat/io/read_splats.h"
#include "splat/io/scene_clouds.h"
#include "splat/io/source_files.h"

namespace swept::io {

std::vector<std::string> files_beside(const ObjectSource& source, const std::string& path) {
  std::vector<std::string> files;
  if (is_sog_meta(path)) files = images_beside(path);
  if (draws_materials(source))
    for (std::string& file : files_of_obj_materials(path)) files.push_back(std::move(file));
  return files;
}

Result<std::vector<std::string>> files_read(const SceneFile& file, double frame) {
  return guarded(file.path(), [&]() -> Result<std::vector<std::string>> {
    Scene at_frame;
    at_frame.frame = frame;
    at_frame.film = file.scene().film;
    at_frame.shutter = file.scene().shutter;
    at_frame.motion = file.scene().motion;
    std::vector<std::string> paths;
    for (const ObjectSource& source : file.sources()) {
      if (source.draw == DrawAs::triangles && !source.texture.empty()) paths.push_back(source.texture);
      const Result<SourceFiles> files = source_files(source, at_frame);
      if (!files) return files.error();
      for (const KeyFile& key : files->files) {
        paths.push_back(key.path);
        for (std::string& beside : files_beside(source, key.path)) paths.push_back(std::move(beside));
      }
    }
    return paths;
  });
}

}  // namespace swept::io
