#include "tools/study/report.h"

#include <array>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <set>
#include <string_view>

#include <fmt/core.h>

#include "splat/io/atomic_file.h"
#include "splat/io/file_bytes.h"
#include "tools/study/report_assets.h"

namespace swept {
namespace {

using nlohmann::ordered_json;

// In the order in which they need each other.
constexpr std::array scripts{"format.js",     "axes.js",      "labels.js",       "plot.js",
                             "scene_plot.js", "tables.js",    "verdict.js",      "series.js",
                             "pictures.js",   "traversal.js", "study_tables.js", "report.js"};

// Disk full and the like show in AtomicFile::commit(), which looks at the stream's error state.
void write(const AtomicFile& file, std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), file.stream());
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = bytes.size() - i;
    const auto byte = [&](std::size_t k) -> std::uint32_t {
      return k < left ? static_cast<unsigned char>(bytes[i + k]) : 0U;
    };
    const std::uint32_t group = byte(0) << 16 | byte(1) << 8 | byte(2);
    text += digits[group >> 18];
    text += digits[group >> 12 & 63];
    text += left > 1 ? digits[group >> 6 & 63] : '=';
    text += left > 2 ? digits[group & 63] : '=';
  }
  return text;
}

/// Inside an attribute in double quotes.
std::string attribute(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    if (c == '&')
      safe += "&amp;";
    else if (c == '"')
      safe += "&quot;";
    else if (c == '<')
      safe += "&lt;";
    else
      safe += c;
  }
  return safe;
}

/// JSON that can stand in a <script> element: no text in it ends the element or opens a comment.
std::string json_for_script(const ordered_json& document) {
  const std::string text = document.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
  std::string safe;
  safe.reserve(text.size());
  for (const char c : text) {
    if (c == '<')
      safe += "\\u003c";  // a < stands in strings alone
    else
      safe += c;
  }
  return safe;
}

/// Paths of all images, each once.
std::set<std::string> images_of(const ordered_json& study) {
  std::set<std::string> paths;
  const auto add = [&](const ordered_json& holder, const char* key) {
    const auto found = holder.find(key);
    if (found != holder.end() && found->is_string()) paths.insert(found->get<std::string>());
  };
  for (const ordered_json& scene : study["scenes"]) {
    if (const auto reference = scene.find("reference"); reference != scene.end()) add(*reference, "image");
    const auto cells = scene.find("cells");
    if (cells == scene.end()) continue;
    for (const ordered_json& cell : *cells) {
      add(cell, "image");
      add(cell, "difference");
    }
  }
  return paths;
}

/// Each image is text in an element of its own, so that a browser decodes only those it is asked to show.
Status write_images(const AtomicFile& file, const ordered_json& study, const std::string& image_folder) {
  constexpr std::string_view signature = "\x89PNG\r\n\x1a\n";
  for (const std::string& image : images_of(study)) {
    const std::string path = (std::filesystem::path(image_folder) / image).string();
    const Result<std::string> bytes = read_bytes(path);
    if (!bytes) return bytes.error();
    if (!bytes->starts_with(signature)) return Error{path, "", "is not a PNG file"};
    write(file, fmt::format("<script type=\"text/plain\" data-image=\"{}\">", attribute(image)));
    write(file, base64(*bytes));
    write(file, "</script>\n");
  }
  return Done{};
}

Status fill(const AtomicFile& file, std::string_view slot, const ordered_json& study,
            const std::string& image_folder) {
  if (slot == "css") {
    write(file, report_asset("report.css"));
  } else if (slot == "plotly") {
    write(file, report_asset("plotly.js"));
  } else if (slot == "study") {
    write(file, json_for_script(study));
  } else if (slot == "images") {
    return write_images(file, study, image_folder);
  } else if (slot == "scripts") {
    for (const char* name : scripts) write(file, report_asset(name));
  } else {
    return Error{"report.html", std::string(slot), "is not a part of the report"};
  }
  return Done{};
}

}  // namespace

Status write_report(const std::string& path, const ordered_json& study, const std::string& image_folder) {
  if (!study.is_object() || !study.contains("scenes") || !study["scenes"].is_array())
    return Error{"", "/scenes", "is not a list"};
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file) return file.error();

  // The template's {{slots}}; what is put into one is not looked at again.
  std::string_view rest = report_asset("report.html");
  for (;;) {
    const std::size_t open = rest.find("{{");
    write(*file, rest.substr(0, open));
    if (open == std::string_view::npos) break;
    const std::size_t close = rest.find("}}", open);
    const Status filled = fill(*file, rest.substr(open + 2, close - open - 2), study, image_folder);
    if (!filled) return filled.error();
    rest.remove_prefix(close + 2);
  }
  return file->commit();
}

bool report_has_plots() { return !report_asset("plotly.js").empty(); }

}  // namespace swept
