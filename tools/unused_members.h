// Members of a scene file that change nothing of what is drawn, as unused_options() of the command line's.
#pragma once

#include <string>
#include <vector>

#include "splat/io/scene_file.h"

namespace swept {

struct UnusedMember {
  std::string pointer;   ///< "/objects/0/velocity/unit"; "*" stands for every element of an array of keys
  std::string reason;    ///< "nothing of it moves by velocities"
  bool but_one = false;  ///< of several keys one counts, and the reason says which

  /// "scene.json: /shutter/opening changes nothing: the shutter's curve is no trapezoid".
  [[nodiscard]] std::string text(const std::string& file) const;
};

/// Those members of `file`, but for ones that say what holds without them, that would leave the picture of
/// `scene`, a frame of it, as it is were they left out, whatever method draws it. What options `given`
/// replace is not told, nor what takes care of points that may come: a shape's velocities that are ignored,
/// gaps.
[[nodiscard]] std::vector<UnusedMember> unused_members(const SceneOverrides& given, const SceneFile& file,
                                                       const Scene& scene);

/// The members, of all frames of a run: told by the last one, as what moves in one frame stands in others.
class RunMembers {
 public:
  /// `frames`: how many will be asked for.
  explicit RunMembers(std::size_t frames) : left_(frames) {}

  /// Of the last of the frames, the texts of those that change nothing in any of them; else nothing.
  [[nodiscard]] std::vector<std::string> of_frame(const std::vector<UnusedMember>& members,
                                                  const std::string& file);

 private:
  std::size_t left_;
  bool first_ = true;
  std::vector<std::string> common_;
};

}  // namespace swept
