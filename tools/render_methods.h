// The methods that `swept render` knows, in one table, and the options that they take.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/App.hpp>

#include "splat/render_control.h"
#include "splat/result.h"
#include "tools/frame_renderer.h"

namespace swept {

/// An option that some methods take and others do not.
struct MethodOption {
  enum class Kind { flag, whole, number, word, text };
  std::string_view name;
  Kind kind = Kind::flag;
  std::string_view help;
  double low = 0.0, high = 0.0;              ///< of numbers
  std::vector<std::string_view> words = {};  ///< of a word
  std::string_view type_name = {};           ///< of a text
  std::string_view example = {};             ///< of a text that may not be anything
};

/// What the command line says to the method, by option; only what is given.
class MethodArguments {
 public:
  void give(std::string_view option, std::string text) { texts_[std::string(option)] = std::move(text); }
  [[nodiscard]] bool given(std::string_view option) const { return texts_.contains(option); }
  /// Precondition of both numbers: the option's text is one.
  [[nodiscard]] double number(std::string_view option, double otherwise) const;
  [[nodiscard]] int whole(std::string_view option, int otherwise) const;
  [[nodiscard]] std::string text(std::string_view option, std::string_view otherwise) const;
  [[nodiscard]] std::vector<std::string> options() const;

  bool expect_error = false;  ///< the channel "error" is asked for, of methods that have it
  bool expect_deep = false;   ///< samples by depth are, likewise

 private:
  std::map<std::string, std::string, std::less<>> texts_;
};

/// A renderer with its options filled in.
struct PreparedMethod {
  std::shared_ptr<FrameRenderer> renderer;
  std::vector<std::pair<std::string, double>> options;  ///< for the statistics
  std::string picture;                                  ///< what of method and options is in the image
};

struct RenderMethod {
  std::string_view name, help;
  std::vector<std::string_view> options;  ///< names in method_options()
  bool built = true;                      ///< false: this swept lacks it, and prepare() says so
  /// The error's field is the option at fault.
  Result<PreparedMethod> (*prepare)(const MethodArguments&, const RenderControl&) = nullptr;
};

/// The first one is the default. A new method is one entry here, and one in method_options() for every option
/// that is new.
[[nodiscard]] const std::vector<RenderMethod>& render_methods();
[[nodiscard]] const std::vector<MethodOption>& method_options();

/// What --method and the options of the methods ask for.
struct MethodChoice {
  std::string method;
  MethodArguments arguments;
};

/// Adds --method and method_options() to `command`. Values out of range are parse errors.
[[nodiscard]] std::shared_ptr<const MethodChoice> add_method_options(CLI::App& command);

/// Errors: options that go with other methods, and those of the method itself; the field is the option.
[[nodiscard]] Result<PreparedMethod> prepare_method(const MethodChoice& choice, const RenderControl& control);

}  // namespace swept
