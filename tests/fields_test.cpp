// The one table of fields: what is in it is read, written, set by the command line, hashed and documented,
// and no member of the scene is left out.
#include "splat/fields.h"

#include <array>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include "tests/scene_text.h"
#include "tools/scene_options.h"

namespace swept {
namespace {

using nlohmann::json;
using test::base_scene;

/// What takes any member's place when the members of an aggregate are counted.
struct Anything {
  template <class T>
  operator T() const;
};

template <class T, class... Given>
constexpr std::size_t member_count() {
  if constexpr (requires { T{Given{}..., Anything{}}; })
    return member_count<T, Given..., Anything>();
  else
    return sizeof...(Given);
}

/// Legal values that differ from those a scene has.
std::vector<double> other_values(const Field& field, const std::vector<double>& present) {
  if (field.count != nullptr) return {0.5, 1.0, 0.25};
  std::vector<double> values;
  for (std::size_t i = 0; i < field.numbers.size(); ++i) {
    const FieldNumber& number = field.numbers[i];
    const double step = number.whole ? 1.0 : 0.125;
    const double value = present[i] + (present[i] + step <= number.high ? step : -step);
    values.push_back(field.words.empty() ? value : 1.0 - present[i]);
  }
  return values;
}

json json_of(const Field& field, const std::vector<double>& values) {
  if (!field.words.empty()) return field.words[static_cast<std::size_t>(values[0])];
  return field.numbers.size() == 1 ? json(values[0]) : json(values);
}

class Fields : public test::SceneFiles {
 protected:
  SceneFile read(const std::string& text, const SceneOverrides& overrides = {}) const {
    Result<SceneFile> file = scene_from_text(text, "scene.json", overrides);
    EXPECT_TRUE(file.ok()) << file.error().message();
    if (!file.ok()) std::abort();  // nothing after it would make sense
    return std::move(*file);
  }
};

TEST_F(Fields, EveryMemberHasAnEntry) {
  std::map<std::string_view, std::size_t> numbers;
  for (const Field& field : scene_fields())
    numbers[field.group()] += field.count != nullptr ? 1 : field.numbers.size();
  EXPECT_EQ(numbers["film"], member_count<Film>());
  EXPECT_EQ(numbers["shutter"], member_count<Shutter>());
  EXPECT_EQ(numbers["image"], member_count<ImageModel>());
  EXPECT_EQ(numbers["splats"], member_count<SplatModel>());
  EXPECT_EQ(numbers[""], member_count<FrameRate>() + 4) << "rate and background";
  struct Three {
    int a;
    double b;
    Coverage c;
  };
  static_assert(member_count<Three>() == 3);
}

TEST_F(Fields, AreReadWrittenHashedAndSetByTheCommandLine) {
  const SceneFile base = read(base_scene);
  const std::string base_hash = *base.hash(7.0);
  std::set<std::string> hashes = {base_hash};
  for (const Field& field : scene_fields()) {
    const std::string pointer(field.pointer);
    SCOPED_TRACE(pointer);
    const std::vector<double> values = other_values(field, field.get(base.scene()));
    ASSERT_TRUE(field.legal(values).ok()) << field.legal(values).error().message();

    json document = json::parse(base_scene);
    document[json::json_pointer(pointer)] = json_of(field, values);
    const SceneFile from_file = read(document.dump());
    EXPECT_EQ(field.get(from_file.scene()), values);
    EXPECT_NE(*from_file.hash(7.0), base_hash);

    SceneOverrides overrides;
    overrides.fields[pointer] = values;
    const SceneFile overridden = read(base_scene, overrides);
    EXPECT_EQ(field.get(overridden.scene()), values);
    EXPECT_TRUE(hashes.insert(*overridden.hash(7.0)).second) << "the hash does not follow it";

    // Written and read back, on top of a scene that says something else.
    json written = json::parse(base_scene);
    written.update(json::parse(fields_to_text(overridden.scene())), true);
    const SceneFile again = read(written.dump());
    for (const Field& any : scene_fields())
      EXPECT_EQ(any.get(again.scene()), any.get(overridden.scene())) << any.pointer;
  }
}

TEST_F(Fields, EveryOptionSetsItsFields) {
  const SceneFile base = read(base_scene);
  std::map<std::string, std::string> texts;
  std::map<std::string, std::vector<double>> expected;
  for (const Field& field : scene_fields()) {
    const std::vector<double> values = other_values(field, field.get(base.scene()));
    expected[std::string(field.pointer)] = values;
    std::string& text = texts[std::string(field.option)];
    for (const double value : values) {
      if (!text.empty()) text += field.separator;
      text += field.words.empty() ? shortest_text(value) : value_text(field, values);
    }
  }
  for (const auto& [option, text] : texts) {
    SCOPED_TRACE(option + ' ' + text);
    CLI::App app;
    const auto overrides = add_scene_options(app);
    try {
      app.parse(option + '=' + text);
    } catch (const CLI::ParseError& error) {
      ADD_FAILURE() << error.what();
      continue;
    }
    const SceneFile file = read(base_scene, *overrides);
    for (const Field& field : scene_fields()) {
      const bool set = field.option == option;
      EXPECT_EQ(field.get(file.scene()), set ? expected[std::string(field.pointer)] : field.get(base.scene()))
          << field.pointer;
    }
  }
}

TEST_F(Fields, RangesHoldInFilesOptionsAndMemory) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const Field& field : scene_fields()) {
    for (std::size_t i = 0; i < field.numbers.size(); ++i) {
      const FieldNumber& number = field.numbers[i];
      // Beyond what a float rounds to a limit.
      const double step = number.whole ? 1.0 : 0.01 * std::max(1.0, number.high);
      for (const double outside :
           {number.low - step, number.high + step, infinity, number.above_low ? number.low : -infinity}) {
        SCOPED_TRACE(std::string(field.pointer) + ' ' + shortest_text(outside));
        std::vector<double> values = field.get(read(base_scene).scene());
        if (field.unset(values)) values = other_values(field, values);
        if (i >= values.size()) continue;  // a list has any length
        values[i] = outside;
        const Status legal = field.legal(values);
        ASSERT_FALSE(legal.ok());
        EXPECT_TRUE(legal.error().field.starts_with(field.pointer));

        SceneOverrides overrides;
        overrides.fields[std::string(field.pointer)] = values;
        EXPECT_FALSE(scene_from_text(base_scene, "scene.json", overrides).ok());
        if (number.whole && !(std::abs(outside) <= 1e9)) continue;  // no int
        Scene scene = read(base_scene).scene();
        field.set(scene, values);
        // Zero throughout may stand for nothing said.
        if (field.unset(field.get(scene))) continue;
        EXPECT_FALSE(scene.validate().ok());
      }
    }
  }
}

TEST_F(Fields, WhatIsUnsetIsNotWritten) {
  const json written = json::parse(fields_to_text(Scene()));
  EXPECT_FALSE(written["film"].contains("crop"));
  EXPECT_FALSE(written["image"].contains("segments"));
  EXPECT_EQ(written["film"]["width"], 1024);
  EXPECT_EQ(written["fps"], (json{24, 1}));
  EXPECT_EQ(written["image"]["coverage"], "soft");
}

TEST_F(Fields, UnknownOverridesAreErrors) {
  SceneOverrides overrides;
  overrides.fields["/image/deltas"] = {1.0};
  const Result<SceneFile> file = scene_from_text(base_scene, "scene.json", overrides);
  ASSERT_FALSE(file.ok());
  EXPECT_EQ(file.error().field, "/image/deltas");
}

/// "R, G, B between -1 and 1; A between 0 and 1", or the one range of all.
std::string ranges_of(const Field& field) {
  std::vector<std::pair<std::string, std::string>> ranges;  // and whose
  for (std::size_t i = 0; i < (field.count != nullptr ? 1 : field.numbers.size()); ++i) {
    const std::string range = range_text(field, i);
    const std::string name(field.numbers[i].name);
    if (!ranges.empty() && ranges.back().first == range)
      ranges.back().second += ", " + name;
    else
      ranges.emplace_back(range, name);
  }
  if (ranges.size() == 1) return ranges[0].first;
  std::string text;
  for (const auto& [range, names] : ranges) (text += text.empty() ? "" : "; ") += names + ' ' + range;
  return text;
}

std::string manual_row(const Field& field) {
  std::string key(field.pointer.substr(1));
  if (const std::size_t slash = key.find('/'); slash != std::string::npos) key[slash] = '.';
  const std::vector<double> values = field.get(Scene());
  const std::string value =
      field.unset(values) ? std::string(field.if_zero) : '`' + value_text(field, values) + '`';
  return "| `" + key + "` | `" + std::string(field.option) + "` | " + value + " | " + ranges_of(field) +
         " | " + std::string(field.help) + " |\n";
}

TEST_F(Fields, TheManualIsTheTable) {
  std::string table = "| key | option | default | range | meaning |\n|---|---|---|---|---|\n";
  for (const Field& field : scene_fields()) table += manual_row(field);
  EXPECT_NE(test::content_of(SWEPT_SCENE_MANUAL).find("\n\n" + table + "\n"), std::string::npos)
      << "the manual lacks the table\n"
      << table;
}

}  // namespace
}  // namespace swept
