#include "splat/io/gltf_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <utility>

#include "splat/io/file_bytes.h"
#include "splat/io/gltf_bytes.h"
#include "splat/io/json_text.h"

namespace swept::io {
namespace {

// Indices, counts and byte offsets; all of them fit into a double.
constexpr long long most = 1LL << 53;
/// Elements of an accessor that no bytes stand for: zeros.
constexpr std::size_t most_zeros = 1 << 16;

template <class T>
double load(const char* from) {
  static_assert(std::endian::native == std::endian::little, "glTF is little-endian");
  T value;
  std::memcpy(&value, from, sizeof value);
  return static_cast<double>(value);
}

struct ComponentType {
  int code;
  std::size_t bytes;
  double full;  ///< what a normalised 1 is stored as; 0: never normalised
};
constexpr ComponentType component_types[] = {{5120, 1, 127.0},   {5121, 1, 255.0}, {5122, 2, 32767.0},
                                             {5123, 2, 65535.0}, {5125, 4, 0.0},   {5126, 4, 0.0}};

const ComponentType* component_type(int code) {
  for (const ComponentType& type : component_types)
    if (type.code == code) return &type;
  return nullptr;
}

std::size_t size_at(const JsonNode& node, const char* key, std::size_t otherwise) {
  const std::optional<JsonNode> found = node.find(key);
  return found ? static_cast<std::size_t>(found->integer(0, most)) : otherwise;
}

const ComponentType& component_type_of(const JsonNode& node) {
  const JsonNode code = node.require("componentType");
  const ComponentType* const type = component_type(static_cast<int>(code.integer(0, 1 << 20)));
  if (!type) code.fail("is no type of component that glTF 2.0 has");
  return *type;
}

}  // namespace

double GltfAccessor::number(std::size_t element, std::size_t component) const {
  const ComponentType& type = *component_type(type_);
  const char* const from = data_ + element * stride_ + component * type.bytes;
  double value = 0.0;
  switch (type_) {
    case 5120:
      value = load<std::int8_t>(from);
      break;
    case 5121:
      value = load<std::uint8_t>(from);
      break;
    case 5122:
      value = load<std::int16_t>(from);
      break;
    case 5123:
      value = load<std::uint16_t>(from);
      break;
    case 5125:
      value = load<std::uint32_t>(from);
      break;
    default:
      value = load<float>(from);
  }
  return normalized_ ? std::max(value / type.full, -1.0) : value;
}

GltfFile::GltfFile(const std::string& path, std::string_view bytes)
    : path_(std::make_unique<const std::string>(path)) {
  read_document(bytes);
}

GltfFile::GltfFile(const std::string& path) : path_(std::make_unique<const std::string>(path)) {
  Result<std::string> bytes = read_bytes(path);
  if (!bytes) throw bytes.error();
  content_ = std::make_unique<const std::string>(*std::move(bytes));
  read_document(*content_);
}

void GltfFile::read_document(std::string_view bytes) {
  const GltfChunks chunks = split_gltf(path(), bytes);
  Result<nlohmann::json> document = parse_json(path(), std::string(chunks.json));
  if (!document) throw document.error();
  document_ = std::make_unique<const nlohmann::json>(*std::move(document));
  chunk_ = chunks.binary;
  const JsonNode asset = root().require("asset"), version = asset.require("version");
  if (!version.string().starts_with("2.")) version.fail("is " + version.string() + ", not 2.0");
  const std::optional<JsonNode> least = asset.find("minVersion");
  if (least && least->string() != "2.0") least->fail("is " + least->string() + ", not 2.0");
}

std::size_t GltfFile::index_in(const std::string& array, const JsonNode& index) const {
  const std::optional<JsonNode> all = root().find(array);
  if (all && !all->is_array()) all->fail("expected an array");
  const std::size_t count = all ? all->json().size() : 0;
  const auto found = static_cast<std::size_t>(index.integer(0, most));
  if (found >= count)
    index.fail("names no element of " + array + ", of which there are " + std::to_string(count));
  return found;
}

JsonNode GltfFile::element(const std::string& array, const JsonNode& index) const {
  return root().require(array).at(index_in(array, index));
}

std::string_view GltfFile::buffer(const JsonNode& index) const {
  const std::size_t i = index_in("buffers", index);
  if (const auto found = buffers_.find(i); found != buffers_.end()) return found->second.bytes;
  const JsonNode node = element("buffers", index);
  const std::optional<JsonNode> uri = node.find("uri");
  if (!uri && (i != 0 || !chunk_)) node.fail("has no uri, and the file no binary chunk for it");
  const Buffer read = uri ? read_buffer(*uri) : Buffer{*chunk_, nullptr};
  const JsonNode length = node.require("byteLength");
  if (const auto wanted = static_cast<std::size_t>(length.integer(1, most)); wanted > read.bytes.size())
    length.fail("is " + std::to_string(wanted) + ", of which " + std::to_string(read.bytes.size()) +
                " bytes are there");
  return buffers_.emplace(i, read).first->second.bytes;
}

GltfFile::Buffer GltfFile::read_buffer(const JsonNode& uri) const {
  const auto owned = [](std::string bytes) {
    const auto own = std::make_shared<const std::string>(std::move(bytes));
    return Buffer{*own, own};
  };
  const std::string& text = uri.string();
  if (text.starts_with("data:")) {
    std::optional<std::string> data = data_of_uri(text);
    if (!data) uri.fail("is a data URI without well-formed base64");
    return owned(*std::move(data));
  }
  const std::optional<std::string> name = file_of_uri(path(), text);
  if (!name) uri.fail("must be data or the relative path of a file");
  if (const auto found = files_.find(*name); found != files_.end()) return found->second;
  Result<std::string> content = read_bytes(*name);
  if (!content) throw content.error();
  return files_.emplace(*name, owned(*std::move(content))).first->second;
}

std::size_t GltfFile::buffer_bytes() const {
  std::map<const char*, std::size_t> distinct;
  for (const auto& [index, buffer] : buffers_) distinct[buffer.bytes.data()] = buffer.bytes.size();
  std::size_t sum = 0;
  for (const auto& [data, size] : distinct) sum += size;
  return sum;
}

std::string_view GltfFile::view(const JsonNode& index, std::size_t& stride) const {
  const JsonNode node = element("bufferViews", index);
  if (const auto extensions = node.find("extensions"))
    for (const std::string& name : extensions->keys())
      if (name.find("compression") != std::string::npos)
        node.fail("is compressed by " + name + ", which is not known");
  const std::string_view bytes = buffer(node.require("buffer"));
  const std::size_t offset = size_at(node, "byteOffset", 0), length = size_at(node, "byteLength", 0);
  if (offset > bytes.size() || length > bytes.size() - offset)
    node.fail("ends at byte " + std::to_string(offset + length) + " of a buffer of " +
              std::to_string(bytes.size()));
  stride = size_at(node, "byteStride", 0);
  if (node.find("byteStride") && (stride < 4 || stride > 252)) node.fail("has a byteStride outside [4, 252]");
  return bytes.substr(offset, length);
}

GltfAccessor GltfFile::accessor(const JsonNode& index, std::string_view type) const {
  const JsonNode node = element("accessors", index);
  constexpr std::array<std::pair<std::string_view, std::size_t>, 7> types{
      {{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}}};
  const JsonNode found_type = node.require("type");
  if (found_type.string() != type)
    found_type.fail("is \"" + found_type.string() + "\", not " + std::string(type));
  GltfAccessor accessor;
  accessor.components_ =
      std::find_if(types.begin(), types.end(), [&](const auto& t) { return t.first == type; })->second;
  const ComponentType& component = component_type_of(node);
  accessor.type_ = component.code;
  if (const auto normalized = node.find("normalized")) accessor.normalized_ = normalized->boolean();
  if (accessor.normalized_ && !(component.full > 0.0)) node.fail("has components that cannot be normalized");
  // Columns of smaller components would be padded.
  if (type.starts_with("MAT") && component.bytes != 4)
    node.fail("is a matrix of other components than float");
  accessor.count_ = static_cast<std::size_t>(node.require("count").integer(1, most));
  const std::size_t element_bytes = accessor.components_ * component.bytes;

  if (const auto view_index = node.find("bufferView")) {
    std::size_t stride = 0;
    const std::string_view bytes = view(*view_index, stride);
    accessor.stride_ = stride > 0 ? stride : element_bytes;
    const std::size_t offset = size_at(node, "byteOffset", 0);
    const bool fits = offset <= bytes.size() && element_bytes <= bytes.size() - offset &&
                      accessor.count_ - 1 <= (bytes.size() - offset - element_bytes) / accessor.stride_;
    if (!fits)
      node.require("count").fail("is " + std::to_string(accessor.count_) + ", which a bufferView of " +
                                 std::to_string(bytes.size()) + " bytes does not hold");
    accessor.data_ = bytes.data() + offset;
  } else {
    if (accessor.count_ > most_zeros)
      node.require("count").fail("is " + std::to_string(accessor.count_) + ", and no bufferView holds them");
    accessor.stride_ = element_bytes;
    accessor.own_ = std::make_shared<const std::string>(accessor.count_ * element_bytes, '\0');
    accessor.data_ = accessor.own_->data();
  }
  if (const auto sparse = node.find("sparse")) add_sparse(*sparse, element_bytes, accessor);
  return accessor;
}

void GltfFile::add_sparse(const JsonNode& sparse, std::size_t element_bytes, GltfAccessor& accessor) const {
  const auto count =
      static_cast<std::size_t>(sparse.require("count").integer(1, static_cast<long long>(accessor.count_)));
  const auto part = [&](const JsonNode& node, std::size_t bytes_each) {
    std::size_t stride = 0;
    const std::string_view bytes = view(node.require("bufferView"), stride);
    const std::size_t offset = size_at(node, "byteOffset", 0);
    if (offset > bytes.size() || count > (bytes.size() - offset) / bytes_each)
      node.fail("has fewer than the " + std::to_string(count) + " elements promised");
    return bytes.substr(offset);
  };
  const JsonNode index_node = sparse.require("indices");
  const ComponentType& type = component_type_of(index_node);
  if (type.code != 5121 && type.code != 5123 && type.code != 5125)
    index_node.fail("must be of unsigned components");
  const std::string_view indices = part(index_node, type.bytes);
  const std::string_view values = part(sparse.require("values"), element_bytes);

  std::string dense(accessor.count_ * element_bytes, '\0');
  for (std::size_t i = 0; i < accessor.count_; ++i)
    std::memcpy(dense.data() + i * element_bytes, accessor.data_ + i * accessor.stride_, element_bytes);
  for (std::size_t k = 0; k < count; ++k) {
    std::uint32_t at = 0;
    std::memcpy(&at, indices.data() + k * type.bytes, type.bytes);
    if (at >= accessor.count_)
      index_node.fail("has " + std::to_string(at) + " among them, of " + std::to_string(accessor.count_) +
                      " elements");
    std::memcpy(dense.data() + at * element_bytes, values.data() + k * element_bytes, element_bytes);
  }
  accessor.own_ = std::make_shared<const std::string>(std::move(dense));
  accessor.data_ = accessor.own_->data();
  accessor.stride_ = element_bytes;
}

}  // namespace swept::io
