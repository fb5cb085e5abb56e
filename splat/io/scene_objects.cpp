#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "splat/io/scene_parsing.h"
#include "splat/io/sequence.h"

namespace swept::io {
namespace {

constexpr long long max_frame_number = 1'000'000'000;

std::string resolve(const JsonNode& node, const std::string& folder) {
  const std::string& path = node.string();
  if (path.empty()) node.fail("the path is empty");
  return (std::filesystem::path(folder) / path).string();
}

double frame_of(const JsonNode& node) {
  const double frame = node.number();
  if (std::abs(frame) > most_frame) node.fail("the frame must be between -1e9 and 1e9");
  return frame;
}

std::map<std::string, std::string> parse_attributes(const JsonNode& source) {
  std::map<std::string, std::string> attributes;
  if (const auto node = source.find("attributes"))
    for (const std::string& name : node->keys()) attributes[name] = node->require(name).string();
  return attributes;
}

StoredColor parse_stored_color(const JsonNode& source) {
  StoredColor stored;
  if (const auto range = source.find("color_range")) stored.range = range->positive();
  if (const auto space = source.find("color_space"))
    stored.space = space->one_of({"linear", "srgb"}) == 0 ? ColorSpace::linear : ColorSpace::srgb;
  return stored;
}

GeneratorSource parse_generator(const JsonNode& node) {
  GeneratorSource source;
  source.shape = node.require("generator").string();
  source.points = static_cast<std::size_t>(node.require("points").integer(1, 1'000'000'000));
  for (const std::string& name : node.keys())
    if (name != "generator" && name != "points") source.parameters[name] = node.require(name).number();
  return source;
}

FileSource parse_file(const JsonNode& node, const std::string& folder, double default_frame) {
  node.expect_keys(
      {"file", "frame", "attributes", "color_range", "color_space", "skip_invalid", "end_file", "end_frame"});
  FileSource source;
  source.path = resolve(node.require("file"), folder);
  source.frame = default_frame;
  if (const auto frame = node.find("frame")) source.frame = frame_of(*frame);
  source.attributes = parse_attributes(node);
  source.stored = parse_stored_color(node);
  if (const auto skip = node.find("skip_invalid")) source.skip_invalid = skip->boolean();
  source.end_frame = source.frame + 1.0;
  if (const auto end = node.find("end_file")) source.end_path = resolve(*end, folder);
  if (!source.end_path.empty() && source.skip_invalid)
    node.require("skip_invalid").fail("points that are left out of one of two files no longer match");
  if (const auto end = node.find("end_frame")) {
    if (source.end_path.empty()) end->fail("an end frame goes with \"end_file\"");
    source.end_frame = frame_of(*end);
    if (!(source.end_frame > source.frame)) end->fail("must be after the frame of the first file");
  }
  return source;
}

SequenceSource parse_sequence(const JsonNode& node, const std::string& folder) {
  node.expect_keys({"sequence", "first", "last", "step", "frames", "offset", "gaps", "cycle", "attributes",
                    "color_range", "color_space"});
  SequenceSource source;
  source.pattern = resolve(node.require("sequence"), folder);
  const auto number = [](const JsonNode& of, long long least = -max_frame_number) {
    return static_cast<int>(of.integer(least, max_frame_number));
  };
  if (const auto frames = node.find("frames")) {
    for (const char* other : {"first", "last", "step"})
      if (const auto member = node.find(other)) member->fail("goes without \"frames\"");
    const Result<std::vector<int>> numbers = parse_frame_ranges(frames->string());
    if (!numbers) frames->fail(numbers.error().reason);
    source.numbers = *numbers;
    std::sort(source.numbers.begin(), source.numbers.end());
    if (source.numbers.front() < -max_frame_number || source.numbers.back() > max_frame_number)
      frames->fail("must be between -1e9 and 1e9");
  } else if (node.find("first") || node.find("last")) {
    source.first = number(node.require("first"));
    source.last = number(node.require("last"));
    if (*source.last < *source.first) node.require("last").fail("the last file is before the first");
  }
  if (const auto step = node.find("step")) {
    source.step = number(*step, 1);
    if (!source.first) step->fail("goes with \"first\" and \"last\"");
  }
  if (const auto offset = node.find("offset")) source.offset = number(*offset);
  if (const auto gaps = node.find("gaps")) source.gaps = gaps->boolean();
  if (const auto cycle = node.find("cycle")) source.cycle = cycle->boolean();
  source.attributes = parse_attributes(node);
  source.stored = parse_stored_color(node);
  return source;
}

/// Reads "translate", "rotate" and "scale".
TransformKey parse_transform_key(const JsonNode& node) {
  TransformKey key;
  if (const auto translate = node.find("translate")) key.translate = translate->vector3();
  if (const auto rotate = node.find("rotate")) {
    rotate->expect_keys({"axis", "degrees"});
    const JsonNode axis = rotate->require("axis");
    const Eigen::Vector3d direction = axis.vector3();
    // Scaled first, so that no square overflows or vanishes.
    const double largest = direction.cwiseAbs().maxCoeff();
    if (largest == 0.0) axis.fail("the axis is zero");
    key.rotate_axis = (direction / largest).normalized();
    key.rotate_radians = rotate->require("degrees").number() * std::numbers::pi / 180.0;
  }
  if (const auto scale = node.find("scale"))
    key.scale = scale->is_array() ? scale->vector3() : Eigen::Vector3d::Constant(scale->number());
  return key;
}

TransformTrack parse_transform(const JsonNode& node) {
  TransformTrack track;
  const auto list = node.find("keys");
  if (!list) {
    node.expect_keys({"keys", "translate", "rotate", "scale"});
    track.keys.push_back(parse_transform_key(node));
    return track;
  }
  node.expect_keys({"keys"});
  const std::vector<JsonNode> keys = list->elements();
  double previous = 0.0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    keys[i].expect_keys({"frame", "translate", "rotate", "scale"});
    previous = parse_key_frame(keys[i], i, keys.size(), previous);
    track.keys.push_back(parse_transform_key(keys[i]));
    track.keys.back().frame = previous;
  }
  return track;
}

/// The shape, or the file's name without its folder.
std::string default_name(const ObjectSource& source) {
  if (const auto* generator = std::get_if<GeneratorSource>(&source.points)) return generator->shape;
  const auto* file = std::get_if<FileSource>(&source.points);
  const std::string& path = file ? file->path : std::get<SequenceSource>(source.points).pattern;
  return std::filesystem::path(path).filename().string();
}

VelocityUnit parse_velocity(const JsonNode& node, bool generated) {
  node.expect_keys({"unit"});
  const JsonNode unit = node.require("unit");
  const auto value = static_cast<VelocityUnit>(unit.one_of({"per_second", "per_frame", "ignore"}));
  if (generated && value == VelocityUnit::per_second) unit.fail("generated velocities are per frame");
  return value;
}

TimeStamps parse_stamps(const JsonNode& node) {
  node.expect_keys({"unit", "zero", "sensor"});
  TimeStamps stamps;
  if (const auto unit = node.find("unit"))
    stamps.unit = static_cast<StampUnit>(unit->one_of({"seconds", "frames"}));
  if (const auto zero = node.find("zero")) stamps.zero = zero->number();
  if (const auto sensor = node.find("sensor")) stamps.sensor = parse_transform(*sensor);
  return stamps;
}

}  // namespace

ParsedObject parse_object(const JsonNode& node, const std::string& folder, double default_frame) {
  node.expect_keys({"name", "source", "velocity", "transform", "color", "radius", "radius_scale", "facing",
                    "segments", "draw", "texture", "crease_angle", "stamps"});
  ParsedObject parsed;
  Object& object = parsed.object;
  ObjectSource& source = parsed.source;
  source.pointer = node.pointer();

  const JsonNode points = node.require("source");
  const bool generator = points.find("generator").has_value(), file = points.find("file").has_value(),
             sequence = points.find("sequence").has_value();
  if (generator + file + sequence != 1)
    points.fail("a source has exactly one of \"generator\", \"file\" and \"sequence\"");
  if (generator) source.points = parse_generator(points);
  if (file) source.points = parse_file(points, folder, default_frame);
  if (sequence) source.points = parse_sequence(points, folder);
  if (generator) source.velocity = VelocityUnit::per_frame;

  const auto name = node.find("name");
  object.name = name ? name->string() : default_name(source);
  if (const auto velocity = node.find("velocity")) source.velocity = parse_velocity(*velocity, generator);
  if (const auto transform = node.find("transform")) object.transform = parse_transform(*transform);
  if (const auto color = node.find("color")) {
    if (color->is_array()) {
      source.color = color->vector3().cast<float>();
      if (!(source.color->cwiseAbs().maxCoeff() <= most_color)) color->fail("must be between -1e30 and 1e30");
    } else if (color->is_object()) {
      color->expect_keys({"normals"});
      source.color_by_normals = true;
      const JsonNode toward = color->require("normals");
      source.normals_toward = toward.vector3();
      if (source.normals_toward.isZero(0.0)) toward.fail("the direction is zero");
    } else {
      source.color_by_normals = color->one_of({"normals"}) == 0;
    }
  }
  if (const auto radius = node.find("radius")) source.radius = radius->positive();
  if (const auto scale = node.find("radius_scale")) source.radius_scale = scale->positive();
  if (const auto facing = node.find("facing")) {
    const auto which = facing->one_of({"two_sided", "one_sided", "sideless"});
    object.two_sided = which != 1;
    source.sideless = which == 2;
  }
  if (const auto draw = node.find("draw")) {
    source.draw = static_cast<DrawAs>(draw->one_of({"splats", "surfels", "triangles"}));
    if (generator) draw->fail("goes with files");
    if (source.draw == DrawAs::splats && !file) draw->fail("goes with a single \"file\"");
  }
  if (const auto texture = node.find("texture")) {
    if (source.draw != DrawAs::triangles) texture->fail("goes with \"draw\": \"triangles\"");
    source.texture = resolve(*texture, folder);
  }
  if (const auto crease = node.find("crease_angle")) {
    if (source.draw != DrawAs::triangles) crease->fail("goes with \"draw\": \"triangles\"");
    source.crease_angle = crease->number();
    if (!(*source.crease_angle >= 0.0 && *source.crease_angle <= 180.0))
      crease->fail("must be between 0 and 180 degrees");
  }
  if (const auto stamps = node.find("stamps")) {
    if (!file) stamps->fail("goes with a single \"file\"");
    source.stamps = parse_stamps(*stamps);
  }
  if (const auto segments = node.find("segments"))
    object.segments = static_cast<int>(segments->integer(1, 4096));
  return parsed;
}

}  // namespace swept::io
