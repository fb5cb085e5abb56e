// The parts of the report page, embedded at build.
#pragma once

#include <string_view>

namespace swept {

/// The text of a file of tools/study/report, e.g. "report.css", or "plotly.js"; empty if there is none of
/// that name. "plotly.js" is missing where the build had no plotting library.
[[nodiscard]] std::string_view report_asset(std::string_view name);

}  // namespace swept
