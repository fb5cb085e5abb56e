#include "splat/io/ply_rows.h"

#include <cmath>
#include <vector>

namespace swept {
namespace {

/// Empty, or what is wrong.
std::string skip_list(const PlyProperty& property, PlyNumbers& numbers) {
  const std::optional<double> length = numbers.next(property.count_type);
  if (!length) return numbers.fault();
  if (!(*length >= 0.0 && *length == std::floor(*length) && *length < 0x1p53))
    return "the length of its list is not a whole number ≥ 0";
  const auto count = static_cast<std::uint64_t>(*length);
  if (!numbers.can_hold(count, numbers.least_bytes(property.type)))
    return "its list of " + std::to_string(count) + " entries runs past the end of the file";
  for (std::uint64_t i = 0; i < count; ++i)
    if (!numbers.next(property.type)) return numbers.fault();
  return {};
}

}  // namespace

Status check_ply_size(const std::string& path, const PlyElement& element, const PlyNumbers& numbers) {
  std::uint64_t least = 0;
  for (const PlyProperty& p : element.properties)
    least += numbers.least_bytes(p.is_list ? p.count_type : p.type);
  if (numbers.can_hold(element.count, least)) return Done{};
  return Error{path, element.name,
               "the header promises " + std::to_string(element.count) + " of at least " +
                   std::to_string(least) + " bytes each, the file has " +
                   std::to_string(numbers.bytes_left()) + " bytes left"};
}

Status read_ply_rows(const std::string& path, const PlyElement& element, PlyNumbers& numbers,
                     const PlyRow& row) {
  if (element.properties.empty()) return Done{};
  const bool one_line = !element.has_lists();
  std::vector<double> values(element.properties.size(), 0.0);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    const auto fail = [&](const PlyProperty& property, const std::string& reason) {
      return Error{path, property.name, element.name + " " + std::to_string(i) + ": " + reason};
    };
    if (one_line) numbers.begin_row();
    for (std::size_t p = 0; p < values.size(); ++p) {
      const PlyProperty& property = element.properties[p];
      if (property.is_list) {
        if (std::string fault = skip_list(property, numbers); !fault.empty()) return fail(property, fault);
        continue;
      }
      const std::optional<double> value = numbers.next(property.type);
      if (!value) return fail(property, numbers.fault());
      values[p] = *value;
    }
    if (one_line && !numbers.end_row()) return fail(element.properties.back(), "the line goes on after it");
    if (Status s = row(values); !s) return s;
  }
  return Done{};
}

}  // namespace swept
