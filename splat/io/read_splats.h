// One reader of splats per format; read_splats() picks. Private to splat/io.
#pragma once

#include <string>
#include <string_view>

#include "splat/io/ply_header.h"
#include "splat/io/splat_file.h"

namespace swept::io {

/// Whether the vertices are trained splats, with scale_0, scale_1[, scale_2] and rot_0 … rot_3, or packed
/// ones.
[[nodiscard]] bool declares_splats(const PlyHeader& header);

[[nodiscard]] Result<LoadedSplats> read_splat_ply(const std::string& path, std::string_view bytes,
                                                  const SplatReadOptions& options);

/// Of a header with packed_position among the vertices' properties.
[[nodiscard]] Result<LoadedSplats> read_packed_ply(const std::string& path, std::string_view bytes,
                                                   const PlyHeader& header, const SplatReadOptions& options);
[[nodiscard]] Result<LoadedSplats> read_splat(const std::string& path, std::string_view bytes,
                                              const SplatReadOptions& options);

[[nodiscard]] Result<LoadedSplats> read_spz(const std::string& path, std::string_view bytes,
                                            const SplatReadOptions& options);

[[nodiscard]] Result<LoadedSplats> read_splat_gltf(const std::string& path, std::string_view bytes,
                                                   const SplatReadOptions& options);

[[nodiscard]] Result<LoadedSplats> read_sog(const std::string& path, std::string_view bytes,
                                            const SplatReadOptions& options);

}  // namespace swept::io
