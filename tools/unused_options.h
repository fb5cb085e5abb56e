// Options that were given and change nothing of what is drawn: each is told, so that none is taken for heard.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "splat/io/scene_file.h"
#include "tools/render_methods.h"

namespace swept {

struct UnusedOption {
  std::string option;  ///< "--shutter-ramps"
  std::string reason;  ///< "the shutter's curve is no trapezoid"

  /// "--shutter-ramps changes nothing: the shutter's curve is no trapezoid".
  [[nodiscard]] std::string text() const { return option + " changes nothing: " + reason; }
};

/// Those of the options given for the scene and for the method that would leave the picture of `scene`, a
/// frame of `file`, as it is (and all its bits, unless it is only the lens's points that they turn) were they
/// left out. `method` is what draws it;
/// null: nothing does, and options of methods are not looked at.
///
/// One table says what each option takes; an option that always tells, or that is an error where it cannot,
/// has no entry.
[[nodiscard]] std::vector<UnusedOption> unused_options(const SceneOverrides& given,
                                                       const MethodChoice* method, const SceneFile& file,
                                                       const Scene& scene);

/// Why `option` of the table would leave the picture of `scene` as it is in every method; none: it would not.
[[nodiscard]] std::optional<std::string> why_unused(std::string_view option, const SceneFile& file,
                                                    const Scene& scene);

/// That an error which is asked for, or goes without saying, is not seen to: the scene says through how many
/// points its lens is looked. Empty: it is.
[[nodiscard]] std::string unseen_error(const MethodChoice& method, const Scene& scene);

/// The options that have an entry in the table.
[[nodiscard]] std::vector<std::string_view> options_with_needs();

}  // namespace swept
