// The study as one HTML page that needs nothing else: no server, no network, no other file.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "splat/result.h"

namespace swept {

/// Writes the report of a study to `path`, complete or not at all.
///
/// `study` is the study's document (version 1); what is null or absent in it is left out of the page. The
/// images that it names, PNG files relative to `image_folder`, go into the page. Numbers that are not finite
/// become null. Errors: no "scenes" list, an image that cannot be read or is no PNG, a page that cannot be
/// written.
[[nodiscard]] Status write_report(const std::string& path, const nlohmann::ordered_json& study,
                                  const std::string& image_folder);

/// Whether this build carries the plotting library; without it a report says that its plots are left out.
[[nodiscard]] bool report_has_plots();

}  // namespace swept
