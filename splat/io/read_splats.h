// One reader of splats per format; read_splats() picks. Private to splat/io.
#pragma once

#include <string>
#include <string_view>
#include <vector>

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

/// The same unpacked: `meta` is meta.json, beside which the images lie.
[[nodiscard]] Result<LoadedSplats> read_sog_folder(const std::string& path, std::string_view meta,
                                                   const SplatReadOptions& options);
/// Whether the file is such a meta.json, by its name and what is in it.
[[nodiscard]] bool is_sog_meta(const std::string& path);
/// Images in the file's folder, in order.
[[nodiscard]] std::vector<std::string> images_beside(const std::string& path);

}  // namespace swept::io
