// The methods that the study compares, and their settings.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "splat/rendered.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace swept {

/// One column of the study: a method with the number that sets how hard it tries.
struct Setting {
  std::string method;  ///< an id of study_methods()
  int value = 0;       ///< 0: the method has no number

  friend bool operator==(const Setting&, const Setting&) = default;
};

struct StudyMethod {
  std::string id, name;
  std::string description;        ///< a sentence
  std::string unit, unit_plural;  ///< of the setting; empty: there is none
  std::vector<int> values, quick_values;
};

/// In the order in which they are shown.
[[nodiscard]] const std::vector<StudyMethod>& study_methods();

/// nullptr: there is none of that id.
[[nodiscard]] const StudyMethod* find_study_method(const std::string& id);

[[nodiscard]] std::string setting_id(const Setting& setting);    ///< "gpu-4": names files
[[nodiscard]] std::string setting_text(const Setting& setting);  ///< "4 sub-frames"

/// The stills that everything is judged by, as a setting. Not in study_methods().
[[nodiscard]] Setting reference_setting(int samples);

struct MethodOptions {
  int threads = 0;
  std::string gpu;  ///< device id; empty: the first that works
};

/// What of a setting is the scene's matter: its segments.
void apply_to_scene(const Setting& setting, Scene& scene);

/// A renderer of the setting, through the same public functions that the render command uses. What it opens,
/// such as a device, it keeps. Scenes are to be those of
/// apply_to_scene(). The error says what this build or machine lacks.
[[nodiscard]] Result<std::function<Result<Rendered>(const Scene&)>> renderer_of(const Setting& setting,
                                                                                const MethodOptions& options);

}  // namespace swept
