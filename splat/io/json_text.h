// JSON text to a document, with errors that say where. Private to splat/io.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "splat/result.h"

namespace swept::io {

/// Parses RFC 8259 JSON in UTF-8. Errors carry line and column for syntax, a JSON pointer for a key that
/// appears twice in one object, and refuse numbers beyond double's range. `file` is for messages only.
[[nodiscard]] Result<nlohmann::json> parse_json(const std::string& file, const std::string& text);

/// `pointer` and one more reference token, escaped as RFC 6901 asks.
[[nodiscard]] std::string join_pointer(const std::string& pointer, const std::string& key);

}  // namespace swept::io
