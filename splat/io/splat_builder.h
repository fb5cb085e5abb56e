// Splats one by one into a cloud: what the readers of all splat formats have in common.
#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <string>
#include <utility>

#include <Eigen/Core>

#include "splat/io/splat_file.h"

namespace swept::io {

/// 1 / (2√π), the constant spherical harmonic.
inline constexpr double first_harmonic = 0.28209479177387814;
inline constexpr std::size_t most_harmonics = 16;

/// One splat in double, as a file says it.
struct SplatRow {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d scale = Eigen::Vector3d::Zero();          ///< standard deviations, not their logarithms
  Eigen::Vector4d rotation = Eigen::Vector4d(1, 0, 0, 0);   ///< w x y z, of any length but zero
  double opacity = 1.0;                                     ///< no logit
  std::array<Eigen::Vector3d, most_harmonics> harmonics{};  ///< as in SplatCloud; the degree's are used
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
};

enum class SplatPart { position, scale, rotation, opacity, harmonics, velocity };

/// The file's own name of a number: of the part's component, counted as SplatRow and SplatCloud do.
using SplatNames = std::function<std::string(SplatPart part, std::size_t component)>;

/// 1 / (1 + e^-logit); of ±∞ 1 and 0.
[[nodiscard]] double opacity_of_logit(double logit);

class SplatBuilder {
 public:
  /// For `count` splats, which the file is known to back: memory for them is reserved.
  SplatBuilder(const std::string& path, std::size_t count, int degree, bool velocities,
               const SplatReadOptions& options, SplatNames names);

  /// Errors: numbers that are not finite in single precision, unless such splats are to be skipped, and
  /// numbers out of range.
  Status add(const SplatRow& row);

  /// Leaves out a splat whose numbers the reader found wrong itself; an error unless such are to be skipped.
  Status drop(const std::string& field, const std::string& reason);

  /// Errors: no splats.
  Result<LoadedSplats> finish();

  LoadedSplats loaded;  ///< the readers add what they know of the whole cloud, and notes

 private:
  struct Fault {
    SplatPart part;
    std::size_t component;
    std::string reason;
    bool invalid;  ///< a number that is none, rather than one out of range
  };
  [[nodiscard]] bool find_fault(const SplatRow& row, Fault& fault) const;

  const std::string& path_;
  std::size_t harmonics_, added_ = 0;  ///< of one splat; splats that came, kept or not
  bool velocities_, skip_invalid_;
  SplatNames names_;
};

/// Whether `packed` bytes may stand for so many splats. What is small when unpacked may be as small as it
/// likes when packed; else a cloud takes 64 times as many bytes at most, where measured ones take 5 to 20.
/// Errors, without file and field: they may not.
[[nodiscard]] Status may_hold(std::size_t packed, std::size_t splats, int degree);

/// `error` of something within the file, which does not know its name and field.
[[nodiscard]] inline Error named(Error error, const std::string& file, const std::string& field) {
  return {file, field, std::move(error.reason), in_a_file(error.kind)};
}

}  // namespace swept::io
