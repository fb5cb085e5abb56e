// Images of other programs in a study: judged like the others, without a time.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "splat/result.h"

namespace swept {

struct AddedImage {
  std::string name;  ///< in the report
  std::string path;  ///< of an EXR
};

/// Adds a method for each image to the study's `document`, and a cell to its one scene if that has a
/// reference already; writes previews into `folder`. An image that cannot be read or has another size is a
/// failed cell. Errors: previews that cannot be written.
[[nodiscard]] Status add_images(const std::vector<AddedImage>& images, const std::string& folder,
                                nlohmann::ordered_json& document);

}  // namespace swept
