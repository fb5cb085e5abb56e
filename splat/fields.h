// One table of what a scene says about the image, apart from camera and objects: film, rate, shutter,
// background and image model. Files, the command line, the ranges, the manual and the scene's hash follow it.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "splat/export.h"
#include "splat/result.h"
#include "splat/scene.h"

namespace SWEPT_API swept {

/// One number of a scene. Every member's type converts to a double and back without loss.
struct FieldNumber {
  std::string_view name;  ///< in upper case, as in WIDTH
  double low = 0.0, high = 0.0;
  bool above_low = false;  ///< low itself is outside
  bool whole = false;
  double (*get)(const Scene&) = nullptr;
  void (*set)(Scene&, double) = nullptr;
};

/// A member of a scene file: a number, a word or a list of numbers.
struct Field {
  std::string_view pointer;  ///< where a file has it, "/image/delta"; at most one object deep
  /// What the command line calls it. Fields next to each other may share one: --size has width and height.
  std::string_view option;
  char separator = ',';  ///< between the numbers of the option
  std::string_view unit = {};
  std::string_view help;                     ///< a phrase without full stop, for readers who know the model
  std::vector<FieldNumber> numbers;          ///< several: a file has an array
  std::size_t least = 1;                     ///< how many must be given; those left out are 1
  std::vector<std::string_view> words = {};  ///< the one number is an index into these
  /// For a list of any length up to numbers.size(): its length, and a function that sets it. Else null.
  std::size_t (*count)(const Scene&) = nullptr;
  void (*resize)(Scene&, std::size_t) = nullptr;
  bool with_object = false;  ///< must be given if the object around it is
  /// What happens if all numbers are zero in memory, which then means that nothing was given; no file and no
  /// option can give zero. Empty: zero is a number as any other.
  std::string_view if_zero = {};

  [[nodiscard]] std::string_view group() const;  ///< "image"; empty: a member of the file itself
  [[nodiscard]] std::string_view name() const;   ///< "delta"
  [[nodiscard]] std::vector<double> get(const Scene& scene) const;
  /// Precondition: `values` are legal(), and there are as many as `numbers`, or fewer but at least `least`;
  /// or none, which makes a list of any length empty.
  void set(Scene& scene, std::span<const double> values) const;
  /// Whether `values` mean that nothing was given: see if_zero.
  [[nodiscard]] bool unset(std::span<const double> values) const;
  /// Whether the field can have these values, apart from what other fields say. The error's field is
  /// `pointer`, with an index if one of several numbers is at fault.
  [[nodiscard]] Status legal(std::span<const double> values) const;
};

/// All fields, in the order in which they are shown. Of a scene's members only camera, objects and frame have
/// none.
[[nodiscard]] const std::vector<Field>& scene_fields();

/// The field with this pointer; nullptr: there is none.
[[nodiscard]] const Field* find_field(std::string_view pointer);

/// Values by pointer.
using FieldValues = std::map<std::string, std::vector<double>, std::less<>>;

/// Checks the ranges of all fields whose pointers start with `group`, and how they relate to each other.
[[nodiscard]] Status validate_fields(const Scene& scene, std::string_view group = "");

/// The range of a number as a phrase: "above 0 and at most 50", "between 1 and 65536 pixels", "soft or hard".
/// Empty: any finite number.
[[nodiscard]] std::string range_text(const Field& field, std::size_t number = 0);

/// As a file would say it: "3", "[0, 0, 0, 0]", "soft".
[[nodiscard]] std::string value_text(const Field& field, std::span<const double> values);

/// The shortest decimal number that is read as the same double.
[[nodiscard]] std::string shortest_text(double value);

}  // namespace swept
