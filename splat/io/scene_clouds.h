// What SceneFile keeps from frame to frame. Private to splat/io.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "splat/io/scene_file.h"

namespace swept {

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
  std::map<std::string, Content> contents;  ///< by path
};

}  // namespace swept
