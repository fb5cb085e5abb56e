// What SceneFile keeps from frame to frame. Private to splat/io.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "splat/io/obj_materials.h"
#include "splat/io/scene_file.h"

namespace swept {

/// What an object shows at one frame.
struct SceneFile::LoadedObject {
  SurfelCloud cloud;
  std::vector<Triangle> triangles;
  std::shared_ptr<const Texture> texture;
  std::vector<TextureCorners> texture_corners;
  std::vector<Material> materials;
  std::vector<std::uint32_t> material_of;
  SplatCloud splats;
  std::vector<std::string> notes;
};

struct SceneFile::Clouds {
  /// What is known of the cloud that an object holds at the moment.
  struct State {
    bool keep = false;  ///< loaded, and the same at every frame
    std::vector<std::string> notes;
  };
  struct Content {
    std::filesystem::file_time_type changed;
    std::string hash;
  };
  std::vector<State> objects;
  double ahead_frame = 0.0;
  std::map<std::size_t, LoadedObject> ahead;           ///< by object, as they are at that frame
  std::map<std::string, Content> contents;             ///< by path
  std::map<std::size_t, io::MaterialFiles> materials;  ///< by object, as of the frame loaded last
};

}  // namespace swept
