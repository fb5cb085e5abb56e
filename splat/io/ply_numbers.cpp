#include "splat/io/ply_numbers.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "splat/io/file_bytes.h"

namespace swept {
namespace {

template <class T>
double load(const char* from, bool swap) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), from, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return static_cast<double>(std::bit_cast<T>(raw));
}

double load_number(const char* from, PlyType type, bool swap) {
  if (type.kind == PlyType::Kind::real) {
    return type.bytes == 4 ? load<float>(from, swap) : load<double>(from, swap);
  }
  const bool is_signed = type.kind == PlyType::Kind::signed_integer;
  if (type.bytes == 1) return is_signed ? load<std::int8_t>(from, swap) : load<std::uint8_t>(from, swap);
  if (type.bytes == 2) return is_signed ? load<std::int16_t>(from, swap) : load<std::uint16_t>(from, swap);
  return is_signed ? load<std::int32_t>(from, swap) : load<std::uint32_t>(from, swap);
}

}  // namespace

PlyNumbers::PlyNumbers(std::string_view body, PlyFormat format)
    : body_(body),
      ascii_(format == PlyFormat::ascii),
      swap_((format == PlyFormat::big_endian) != (std::endian::native == std::endian::big)) {}

std::optional<double> PlyNumbers::next(PlyType type) {
  if (!ascii_) {
    if (body_.size() < type.bytes) return std::nullopt;
    const double value = load_number(body_.data(), type, swap_);
    body_.remove_prefix(type.bytes);
    return value;
  }
  body_.remove_prefix(std::min(body_.find_first_not_of(one_line_ ? " \t" : " \t\r\n"), body_.size()));
  token_ = body_.substr(0, body_.find_first_of(" \t\r\n"));
  body_.remove_prefix(token_.size());
  return parse_number(token_);
}

void PlyNumbers::begin_row() {
  if (ascii_) body_.remove_prefix(std::min(body_.find_first_not_of(" \t\r\n"), body_.size()));
  one_line_ = true;
}

bool PlyNumbers::end_row() {
  one_line_ = false;
  if (!ascii_) return true;
  token_ = body_.substr(0, body_.find_first_not_of(" \t\r"));
  body_.remove_prefix(token_.size());
  return body_.empty() || body_.front() == '\n';
}

std::string PlyNumbers::fault() const {
  if (ascii_ && !token_.empty()) return not_a_number(token_);
  return body_.empty() || !ascii_ ? "the file ends here" : "the line ends here";
}

bool PlyNumbers::can_hold(std::uint64_t count, std::uint64_t least_bytes) const {
  // One more: the last number of an ASCII file needs no blank after it.
  return least_bytes == 0 || count <= (body_.size() + 1) / least_bytes;
}

std::vector<std::string> PlyNumbers::unread() const {
  if (ascii_ ? body_.find_first_not_of(" \t\r\n") == std::string_view::npos : body_.empty()) return {};
  return {std::to_string(body_.size()) + " bytes after the last element"};
}

}  // namespace swept
