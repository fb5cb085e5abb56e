// The table of methods: every option goes with some method and is refused by the others.
#include "tools/render_methods.h"

#include <algorithm>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

namespace swept {
namespace {

std::string legal_text(const MethodOption& option) {
  switch (option.kind) {
    case MethodOption::Kind::word:
      return std::string(option.words.back());
    case MethodOption::Kind::text:
      return option.example.empty() ? "anything" : std::string(option.example);
    case MethodOption::Kind::flag:
      return "";
    default:
      return std::to_string(static_cast<long long>(std::min(option.high, option.low + 3)));
  }
}

Result<PreparedMethod> prepared(const std::string& line) {
  CLI::App app;
  const auto choice = add_method_options(app);
  app.parse(line);
  return prepare_method(*choice, {});
}

TEST(RenderMethods, EachTakesItsOptionsAndNoOthers) {
  std::set<std::string_view> taken;
  for (const RenderMethod& method : render_methods()) {
    const std::string choose = "--method " + std::string(method.name);
    const Result<PreparedMethod> plain = prepared(choose);
    ASSERT_TRUE(plain.ok()) << plain.error().message();
    EXPECT_TRUE(plain->picture.starts_with(method.name)) << plain->picture;
    ASSERT_NE(plain->renderer, nullptr);
    for (const MethodOption& option : method_options()) {
      const bool goes = std::count(method.options.begin(), method.options.end(), option.name) > 0;
      if (goes) taken.insert(option.name);
      const Result<PreparedMethod> with =
          prepared(choose + ' ' + std::string(option.name) + ' ' + legal_text(option));
      EXPECT_EQ(with.ok(), goes) << method.name << ' ' << option.name;
      if (with.ok()) continue;
      EXPECT_EQ(with.error().field, option.name);
      EXPECT_NE(with.error().reason.find("goes with --method"), std::string::npos);
    }
    for (const std::string_view option : method.options)
      EXPECT_TRUE(std::any_of(method_options().begin(), method_options().end(),
                              [&](const MethodOption& known) { return known.name == option; }))
          << option << " is nobody's";
  }
  EXPECT_EQ(taken.size(), method_options().size()) << "an option goes with no method";
}

TEST(RenderMethods, WhatIsInTheImageIsInItsName) {
  const auto picture = [](const std::string& line) {
    const Result<PreparedMethod> method = prepared(line);
    return method ? method->picture : method.error().message();
  };
  EXPECT_EQ(picture(""), "sampled to 60 dB");
  EXPECT_EQ(picture("--exact"), "abuffer");
  EXPECT_EQ(picture("--max-error 0.01"), "sampled to 40 dB");
  EXPECT_NE(picture("--max-cell-error 50dB"), picture(""));
  EXPECT_NE(picture("--samples 9"), picture("--samples 8"));
  EXPECT_NE(picture("--exact --normalisation pixel"), picture("--exact"));
  EXPECT_EQ(picture("--method reference --samples 8 --reference-motion smooth"), "reference 8 smooth");
  EXPECT_EQ(picture("--method gpu --subframes 3 --lookup-tables"), "gpu 3 tables");
  EXPECT_EQ(picture("--method gpu-still --subframes 3"), "gpu-still 3");
}

TEST(RenderMethods, ValuesOutOfRangeAreParseErrors) {
  for (const char* line : {"--method none", "--subframes -1", "--subframes 65537", "--subframes 1.5",
                           "--method sampled --samples 0", "--samples x", "--normalisation frame"})
    EXPECT_THROW((void)prepared(line), CLI::ParseError) << line;
  EXPECT_EQ(prepared("--method reference --samples 3").ok(), false) << "an odd number";
  for (const char* line : {"--max-error 0", "--max-error 60", "--max-error -1dB", "--max-error 151dB",
                           "--max-error dB", "--max-cell-error 1", "--max-error 50dB --samples 3"})
    EXPECT_FALSE(prepared(line).ok()) << line;
}

}  // namespace
}  // namespace swept
