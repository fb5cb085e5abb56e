// Where the bytes of a glTF file are: chunks of a .glb, data URIs, files beside it. Private to splat/io.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace swept::io {

struct GltfChunks {
  std::string_view json;
  std::optional<std::string_view> binary;
};

/// The chunks of a .glb, or all of a .gltf as its document. Throws an Error where lengths do not fit.
[[nodiscard]] GltfChunks split_gltf(const std::string& path, std::string_view bytes);

/// The bytes of "data:[type];base64,…", if that is what it is.
[[nodiscard]] std::optional<std::string> data_of_uri(std::string_view uri);

/// The file that a relative URI in the file at `path` means; none for other schemes, absolute paths and names
/// with a byte 0.
[[nodiscard]] std::optional<std::string> file_of_uri(const std::string& path, std::string_view uri);

}  // namespace swept::io
