// Errors as values: the library never prints, throws across its API, or exits.
#pragma once

#include <cassert>
#include <cstddef>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "splat/export.h"

namespace SWEPT_API swept {

/// `text` with control characters as `\xNN`: names come from files, and a terminal would obey such
/// characters.
[[nodiscard]] inline std::string printable(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string shown;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7f)
      shown += c;
    else
      ((shown += "\\x") += digits[byte >> 4]) += digits[byte & 15];
  }
  return shown;
}

/// What kind of thing went wrong, for a program that has to decide what to do about it.
enum class ErrorKind {
  argument,       ///< the caller asked for what cannot be: out of range, contradictory, in the wrong order
  not_found,      ///< a file, folder or frame of a sequence is not there, or may not be read
  malformed,      ///< a file does not hold what its format says it should
  unsupported,    ///< valid, but not in this method, format or build
  out_of_memory,  ///< more than the machine has, or than RenderControl::max_bytes allows
  cancelled,      ///< the caller stopped it
  device,         ///< a GPU, a disk or a pipe did not do what it was told to
  empty,          ///< a file says, as its format has it, that it holds no points or splats
};

/// "argument", "not_found", …
[[nodiscard]] constexpr std::string_view error_kind_name(ErrorKind kind) {
  constexpr std::string_view names[] = {"argument",      "not_found", "malformed", "unsupported",
                                        "out_of_memory", "cancelled", "device",    "empty"};
  return names[static_cast<std::size_t>(kind)];
}

/// The kind of an error whose value came from a file: what is an `argument` to a function is `malformed`
/// there.
[[nodiscard]] constexpr ErrorKind in_a_file(ErrorKind kind) {
  return kind == ErrorKind::argument ? ErrorKind::malformed : kind;
}

/// What went wrong, in words for the person who has to mend it.
struct Error {
  std::string file;    ///< path as the caller gave it; empty if no file is involved
  std::string field;   ///< JSON pointer, PLY property, option name, ...; may be empty
  std::string reason;  ///< one sentence without a trailing full stop
  /// By default `malformed` if a file is involved, else `argument`.
  ErrorKind kind = file.empty() ? ErrorKind::argument : ErrorKind::malformed;

  /// "file: field: reason", leaving out what is empty; printable.
  [[nodiscard]] std::string message() const {
    std::string text;
    for (const std::string* part : {&file, &field, &reason}) {
      if (part->empty()) continue;
      if (!text.empty()) text += ": ";
      text += *part;
    }
    return printable(text);
  }
};

/// A value of type T, or the Error that stood in its way.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  [[nodiscard]] bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  /// Precondition: ok().
  T& value() & {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  const T& value() const& {
    assert(ok());
    return *std::get_if<0>(&state_);
  }
  T&& value() && {
    assert(ok());
    return std::move(*std::get_if<0>(&state_));
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  /// Precondition: !ok().
  const Error& error() const {
    assert(!ok());
    return *std::get_if<1>(&state_);
  }

 private:
  std::variant<T, Error> state_;
};

/// Success carries nothing.
struct Done {};
using Status = Result<Done>;

}  // namespace swept
