// A headless Chromium that a test drives over a pipe: no port is opened, and no driver is needed.
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/temporary_folder.h"

namespace swept::test {

/// Speaks the DevTools protocol to a browser of its own, which ends with it. A call that fails or that takes
/// longer than a minute is a failure of the running test, and returns null.
class Browser {
 public:
  /// Nothing if no Chromium is installed.
  static std::unique_ptr<Browser> start();
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  nlohmann::json call(const std::string& method, const nlohmann::json& parameters = nlohmann::json::object());

  /// The value of an expression in the page, a promise's once it is kept.
  nlohmann::json evaluate(const std::string& expression);
  /// Evaluates until the value is true.
  void wait_until(const std::string& expression);

  void resize(int width, int height);
  /// Shows a local file and waits until it is loaded.
  void open(const std::string& path);

  /// Real input, as the browser gets it from a person. Places are of the middle of the first element that
  /// matches.
  void click(const std::string& selector, int times = 1);
  void press(const std::string& key);
  void drag(const std::string& selector, double from_x, double to_x, bool touch);

  /// What the page complained of since it was opened: console errors and warnings, exceptions, refused
  /// requests.
  [[nodiscard]] std::vector<std::string> complaints() const;
  /// Addresses that the page asked for, other than its own and those that hold their data.
  [[nodiscard]] std::vector<std::string> requests() const;

 private:
  Browser() = default;
  void attach();
  nlohmann::json receive();
  nlohmann::json rectangle(const std::string& selector);

  TemporaryFolder profile_;
  pid_t process_ = -1;
  int to_ = -1, from_ = -1, last_id_ = 0;
  std::string session_, unread_, page_;
  std::vector<nlohmann::json> events_;
};

}  // namespace swept::test
