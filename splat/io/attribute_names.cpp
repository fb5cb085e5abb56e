#include "splat/io/attribute_names.h"

#include <algorithm>
#include <array>

namespace swept {
namespace {

using Names = std::vector<std::string>;
using Stems = std::vector<const char*>;

const Names kAxes{"x", "y", "z"}, kDigits{"0", "1", "2"}, kWords{"red", "green", "blue"},
    kLetters{"r", "g", "b"};

// Each also names a property that holds all three numbers. Houdini: P, N, v, Cd.
const Stems kPosition{"p", "pos", "position", "positions", "point", "coord"};
const Stems kNormal{"n", "normal", "normals"};
const Stems kVelocity{"v", "velocity", "velocities", "vel"};
const Stems kAcceleration{"acceleration", "accelerations", "accel", "acc"};
// Houdini: w.
const Stems kAngularVelocity{"angularvelocity", "angularvelocities", "angvel", "omega", "w"};
const Stems kColor{"cd", "color", "colour", "colors", "rgb", "diffuse", "displaycolor"};

void add_vectors(std::vector<Names>& usual, const Stems& stems, const std::vector<Names>& endings) {
  for (const char* stem : stems) {
    for (const Names& ending : endings) {
      Names names;
      for (const std::string& end : ending) names.push_back(stem + end);
      usual.push_back(std::move(names));
    }
  }
}

std::vector<AttributeNames> make_table() {
  std::vector<Names> position{kAxes}, normal, velocity, color{kWords, kLetters};
  std::vector<Names> acceleration{{"ax", "ay", "az"}}, angular;
  add_vectors(position, kPosition, {kAxes, kDigits});
  position.push_back({"easting", "northing", "elevation"});
  position.push_back({"easting", "northing", "height"});
  add_vectors(normal, kNormal, {kAxes, kDigits});
  add_vectors(velocity, kVelocity, {kAxes, kDigits});
  velocity.push_back({"dx", "dy", "dz"});
  add_vectors(acceleration, kAcceleration, {kAxes, kDigits});
  add_vectors(angular, kAngularVelocity, {kAxes, kDigits});
  add_vectors(color, kColor, {kWords, kLetters, kAxes, kDigits});
  return {{"position", 3, 3, position},
          {"normal", 3, 3, normal},
          {"velocity", 3, 3, velocity},
          {"acceleration", 3, 3, acceleration},
          {"angular_velocity", 3, 3, angular},
          {"color", 3, 4, color},
          {"radius", 1, 1, {{"radius"}, {"pscale"}, {"radii"}, {"pointradius"}}},
          {"width", 1, 1, {{"width"}, {"widths"}, {"diameter"}, {"size"}, {"pointsize"}}},
          {"opacity", 1, 1, {{"opacity"}}},
          {"intensity",
           1,
           1,
           {{"intensity"},
            {"intensities"},
            {"reflectivity"},
            {"reflectance"},
            {"remission"},
            {"grey"},
            {"gray"},
            {"i"}}},
          {"id", 1, 1, {{"id"}, {"ids"}, {"pointid"}, {"particleid"}}},
          {"time", 1, 1, {{"time"}, {"t"}, {"timestamp"}, {"timestamps"}, {"gpstime"}}}};
}

}  // namespace

const std::vector<AttributeNames>& attribute_names() {
  static const std::vector<AttributeNames> table = make_table();
  return table;
}

std::string folded(std::string_view name) {
  std::string lower(name);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');  // ASCII only, whatever the locale
  }
  constexpr std::string_view kScalar = "scalar_";
  if (lower.compare(0, kScalar.size(), kScalar) == 0) lower.erase(0, kScalar.size());
  // "x [m]", but not "v[0]" and "v[x]".
  if (const std::size_t open = lower.find_first_of("[("); open != lower.npos && open > 0) {
    const std::size_t close = lower.find_first_of("])", open);
    const bool index = close == open + 2 &&
                       std::string_view("0123456789xyzrgb").find(lower[open + 1]) != std::string_view::npos;
    if (close != lower.npos && !index) lower.erase(open, close + 1 - open);
  }
  std::erase_if(lower,
                [](char c) { return std::string_view(" _.-:[]()\"'").find(c) != std::string_view::npos; });
  return lower;
}

bool is_vector_name(std::string_view name) {
  const std::string plain = folded(name);
  for (const Stems* stems : {&kPosition, &kNormal, &kVelocity, &kAcceleration, &kAngularVelocity, &kColor}) {
    if (std::find(stems->begin(), stems->end(), plain) != stems->end()) return true;
  }
  return false;
}

}  // namespace swept
