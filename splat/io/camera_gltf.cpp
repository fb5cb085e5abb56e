// Cameras of glTF 2.0, perspective and orthographic, with the animation of their node and of those above it.
#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "splat/io/camera_file.h"
#include "splat/io/gltf_file.h"

namespace swept::io {
namespace {

/// Between keys that do not lie on straight lines, samples of a frame, and most of them in all.
constexpr double samples_per_frame = 8.0;
constexpr std::size_t most_keys = std::size_t{1} << 17;

/// A channel of an animation.
struct Channel {
  enum class Path { translation, rotation, scale } path;
  enum class Curve { linear, step, cubic } curve;
  std::size_t node;
  GltfAccessor times, values;

  [[nodiscard]] double time(std::size_t key) const { return times.number(key, 0); }

  /// `part`: 0 the tangent before, 1 the value, 2 the tangent after.
  [[nodiscard]] Eigen::Vector4d read(std::size_t key, std::size_t part = 1) const {
    const std::size_t element = curve == Curve::cubic ? 3 * key + part : key;
    Eigen::Vector4d value = Eigen::Vector4d::Zero();
    for (std::size_t i = 0; i < values.components(); ++i)
      value[static_cast<Eigen::Index>(i)] = values.number(element, i);
    return value;
  }

  [[nodiscard]] Eigen::Vector4d at(double t) const {
    std::size_t after = 0;
    while (after < times.count() && time(after) <= t) ++after;
    if (after == 0) return read(0);
    const std::size_t before = after - 1;
    if (after == times.count() || curve == Curve::step) return read(before);
    const double length = time(after) - time(before), s = (t - time(before)) / length;
    const Eigen::Vector4d a = read(before), b = read(after);
    if (curve == Curve::cubic) {
      const double s2 = s * s, s3 = s2 * s;
      return (2 * s3 - 3 * s2 + 1) * a + length * (s3 - 2 * s2 + s) * read(before, 2) +
             (3 * s2 - 2 * s3) * b + length * (s3 - s2) * read(after, 0);
    }
    if (path == Path::rotation)
      return Eigen::Quaterniond(a).normalized().slerp(s, Eigen::Quaterniond(b).normalized()).coeffs();
    return a + s * (b - a);
  }
};

std::vector<std::size_t> chain_of(const std::vector<GltfNode>& nodes, std::size_t node) {
  std::vector<std::size_t> chain;
  for (std::optional<std::size_t> at = node; at; at = nodes[*at].parent) chain.push_back(*at);
  return chain;
}

Channel channel_of(const GltfFile& file, const JsonNode& animation, const JsonNode& json, std::size_t node,
                   std::size_t path) {
  const JsonNode samplers = animation.require("samplers"), index = json.require("sampler");
  const std::vector<JsonNode> all = samplers.elements();
  const auto number = static_cast<std::size_t>(index.integer(0, 1'000'000'000));
  if (number >= all.size()) index.fail("there is no such sampler");
  const JsonNode& sampler = all[number];
  Channel channel;
  channel.path = static_cast<Channel::Path>(path);
  channel.node = node;
  channel.curve = Channel::Curve::linear;
  if (const auto curve = sampler.find("interpolation"))
    channel.curve = static_cast<Channel::Curve>(curve->one_of({"LINEAR", "STEP", "CUBICSPLINE"}));
  channel.times = file.accessor(sampler.require("input"), "SCALAR");
  channel.values =
      file.accessor(sampler.require("output"), channel.path == Channel::Path::rotation ? "VEC4" : "VEC3");
  const std::size_t each = channel.curve == Channel::Curve::cubic ? 3 : 1;
  if (channel.times.count() == 0 || channel.values.count() != each * channel.times.count())
    sampler.fail("times and values do not fit each other");
  for (std::size_t i = 0; i < channel.times.count(); ++i) {
    const double time = channel.time(i);
    if (!std::isfinite(time) || (i > 0 && !(time > channel.time(i - 1))))
      sampler.require("input").fail("times must increase");
  }
  return channel;
}

/// The first animation that moves one of `chain`, and how many others would too.
std::vector<Channel> channels_of(const GltfFile& file, const std::vector<GltfNode>& nodes,
                                 const std::vector<std::size_t>& chain, std::size_t& others) {
  std::vector<Channel> channels;
  others = 0;
  const auto animations = file.root().find("animations");
  if (!animations) return channels;
  for (const JsonNode& animation : animations->elements()) {
    std::vector<Channel> own;
    for (const JsonNode& json : animation.require("channels").elements()) {
      const JsonNode target = json.require("target");
      const auto node = target.find("node");
      if (!node) continue;
      const std::size_t index = file.index_in("nodes", *node);
      const std::string& path = target.require("path").string();
      constexpr std::string_view paths[] = {"translation", "rotation", "scale"};
      const auto* const known = std::find(std::begin(paths), std::end(paths), path);
      if (known == std::end(paths) || std::find(chain.begin(), chain.end(), index) == chain.end()) continue;
      if (nodes[index].matrix) node->fail("has a matrix, and cannot be animated");
      own.push_back(channel_of(file, animation, json, index, static_cast<std::size_t>(known - paths)));
    }
    if (own.empty()) continue;
    if (channels.empty())
      channels = std::move(own);
    else
      ++others;
  }
  return channels;
}

/// When keys are set, seconds.
std::vector<double> times_of(const std::vector<Channel>& channels, std::size_t camera, double fps) {
  std::vector<double> times;
  bool curved = false;
  for (const Channel& channel : channels) {
    curved = curved || channel.curve == Channel::Curve::cubic || channel.node != camera;
    for (std::size_t i = 0; i < channel.times.count() && times.size() < most_keys; ++i) {
      // A step is from just before it to it.
      if (channel.curve == Channel::Curve::step && i > 0) times.push_back(channel.time(i) - 1e-4 / fps);
      times.push_back(channel.time(i));
    }
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  if (!curved) return times;
  std::vector<double> finer;
  for (std::size_t i = 0; i < times.size(); ++i) {
    finer.push_back(times[i]);
    if (i + 1 == times.size()) break;
    const double steps = std::ceil((times[i + 1] - times[i]) * fps * samples_per_frame);
    if (!(steps + static_cast<double>(finer.size()) < static_cast<double>(most_keys)))
      throw Error{"", "/animations", "the camera's animation is too long to be followed"};
    for (int k = 1; k < static_cast<int>(steps); ++k)
      finer.push_back(times[i] + (times[i + 1] - times[i]) * k / steps);
  }
  return finer;
}

/// `nodes`: those of the chain are left as they are at `time`.
Eigen::Matrix4d pose_at(std::vector<GltfNode>& nodes, const std::vector<std::size_t>& chain,
                        const std::vector<Channel>& channels, double time) {
  for (const Channel& channel : channels) {
    const Eigen::Vector4d value = channel.at(time);
    GltfNode& node = nodes[channel.node];
    if (channel.path == Channel::Path::translation) node.translation = value.head<3>();
    if (channel.path == Channel::Path::scale) node.scale = value.head<3>();
    if (channel.path == Channel::Path::rotation) {
      node.rotation.coeffs() = value.stableNormalized();
      if (value.isZero(0.0)) node.rotation.setIdentity();
    }
  }
  Eigen::Matrix4d pose = Eigen::Matrix4d::Identity();
  for (const std::size_t node : chain) pose = nodes[node].local() * pose;
  // A camera has no size.
  for (int axis = 0; axis < 3; ++axis) {
    const double length = pose.col(axis).head<3>().stableNorm();
    if (length > 0.0) pose.col(axis).head<3>() /= length;
  }
  return pose;
}

nlohmann::json fov_of(const JsonNode& perspective) {
  const JsonNode yfov = perspective.require("yfov");
  if (!(yfov.positive() < std::numbers::pi)) yfov.fail("must be below pi");
  return {{"fov", {{"axis", "vertical"}, {"degrees", yfov.number() * 180.0 / std::numbers::pi}}}};
}

/// ymag is half of what is seen along the height. xmag, which a film of another shape could not show, must be
/// a number all the same.
nlohmann::json height_of(const JsonNode& orthographic) {
  static_cast<void>(orthographic.require("xmag").positive());
  return {{"height", 2.0 * orthographic.require("ymag").positive()}};
}

}  // namespace

CameraFile cameras_of_gltf(const std::string& path, double fps) {
  const GltfFile gltf(path);
  const std::vector<GltfNode> nodes = gltf.nodes();
  std::vector<std::size_t> cameras;
  std::vector<JsonNode> json;
  if (const auto list = gltf.root().find("nodes")) json = list->elements();
  for (const std::size_t node : gltf.nodes_in_scene())
    if (json[node].find("camera")) cameras.push_back(node);
  if (cameras.empty()) throw Error{path, "/nodes", "there is no camera in its scene"};
  const std::size_t node = cameras.front();
  const JsonNode camera = gltf.element("cameras", json[node].require("camera"));
  const bool orthographic = camera.require("type").one_of({"perspective", "orthographic"}) == 1;
  const nlohmann::json view =
      orthographic ? height_of(camera.require("orthographic")) : fov_of(camera.require("perspective"));

  const std::vector<std::size_t> chain = chain_of(nodes, node);
  std::vector<GltfNode> moving = nodes;
  std::size_t others = 0;
  const std::vector<Channel> channels = channels_of(gltf, nodes, chain, others);
  std::vector<double> times = times_of(channels, node, fps);
  if (times.empty()) times = {0.0};
  CameraFile file;
  file.gltf_axes = true;
  file.camera["convention"] = "opengl";
  for (const double time : times) {
    const Eigen::Matrix4d pose = pose_at(moving, chain, channels, time);
    nlohmann::json matrix = nlohmann::json::array();
    for (int i = 0; i < 16; ++i) matrix.push_back(pose(i / 4, i % 4));
    nlohmann::json key = view;
    key["frame"] = 1.0 + time * fps;
    key["matrix"] = std::move(matrix);
    file.camera["keys"].push_back(std::move(key));
    file.places.push_back("/nodes/" + std::to_string(node));
  }
  file.notes.push_back(channels.empty() ? "assumed: the camera of " + path + " stands still"
                                        : "assumed: second 0 of the camera's animation in " + path +
                                              " is frame 1, and the rate that of the scene");
  if (cameras.size() > 1)
    file.notes.push_back("unread: " + std::to_string(cameras.size() - 1) + " more cameras of " + path);
  if (others > 0)
    file.notes.push_back("unread: " + std::to_string(others) + " more animations of the camera");
  return file;
}

}  // namespace swept::io
