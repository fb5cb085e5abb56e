// Strict, typed access to a JSON document. Private to splat/io.
//
// Every refusal throws a swept::Error that names file, JSON pointer and reason; the reader's outermost
// function catches it, so that parsing code reads as a list of what a file may hold.
#pragma once

#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "splat/result.h"

namespace swept::io {

/// A value and where it is. Refers to the document and the file name, and must not outlive them.
class JsonNode {
 public:
  JsonNode(const nlohmann::json& value, const std::string& file) : value_(&value), file_(&file) {}

  [[noreturn]] void fail(const std::string& reason) const;
  [[nodiscard]] const std::string& file() const { return *file_; }
  [[nodiscard]] const std::string& pointer() const { return pointer_; }
  [[nodiscard]] const nlohmann::json& json() const { return *value_; }

  [[nodiscard]] bool is_object() const { return value_->is_object(); }
  [[nodiscard]] bool is_array() const { return value_->is_array(); }
  [[nodiscard]] bool is_number() const { return value_->is_number(); }

  /// Refuses what is no object, and keys other than these.
  void expect_keys(std::span<const std::string_view> known) const;
  void expect_keys(std::initializer_list<std::string_view> known) const {
    expect_keys(std::span<const std::string_view>(known.begin(), known.size()));
  }
  [[nodiscard]] std::optional<JsonNode> find(const std::string& key) const;
  [[nodiscard]] JsonNode require(const std::string& key) const;
  /// Members of an object in the order of their keys, or elements of an array.
  [[nodiscard]] std::vector<std::string> keys() const;
  [[nodiscard]] std::vector<JsonNode> elements() const;

  /// Element `index` of an array. Precondition: there is one.
  [[nodiscard]] JsonNode at(std::size_t index) const;

  [[nodiscard]] double number() const;
  [[nodiscard]] double positive() const;
  /// A whole number within [low, high]; 3.0 counts as one.
  [[nodiscard]] long long integer(long long low, long long high) const;
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] const std::string& string() const;
  /// One of these words; returns its index.
  [[nodiscard]] std::size_t one_of(std::span<const std::string_view> words) const;
  [[nodiscard]] std::size_t one_of(std::initializer_list<std::string_view> words) const {
    return one_of(std::span<const std::string_view>(words.begin(), words.size()));
  }
  [[nodiscard]] std::vector<double> numbers(std::size_t count) const;
  [[nodiscard]] Eigen::Vector3d vector3() const;

 private:
  JsonNode(const nlohmann::json& value, const std::string& file, std::string pointer)
      : value_(&value), file_(&file), pointer_(std::move(pointer)) {}
  void expect(bool right_type, const char* type) const;

  const nlohmann::json* value_;
  const std::string* file_;
  std::string pointer_;
};

}  // namespace swept::io
