#include "tests/study_report/browser.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>
#include <utility>

namespace swept::test {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

// A browser starts in a second or two; a machine with all cores taken may need many times that.
constexpr std::chrono::seconds patience{60};

std::string find_chromium() {
  const char* path = std::getenv("PATH");
  std::string folders = path == nullptr ? "" : path;
  for (std::size_t start = 0; start <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', start), folders.size());
    for (const char* name : {"chromium", "chromium-browser", "google-chrome"}) {
      const std::string candidate = folders.substr(start, end - start) + "/" + name;
      if (access(candidate.c_str(), X_OK) == 0) return candidate;
    }
    start = end + 1;
  }
  return {};
}

/// In the child: the browser reads from descriptor 3 and writes to 4.
[[noreturn]] void become(const std::string& program, const std::string& profile, int reads, int writes) {
  setpgid(0, 0);
  // Out of the way first, in case one of them is the other's destination.
  const int in = fcntl(reads, F_DUPFD, 10), out = fcntl(writes, F_DUPFD, 10);
  dup2(in, 3);
  dup2(out, 4);
  close(in);
  close(out);
  const int nothing = open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, stream);
  // Without a sandbox, which a browser cannot have as root; it opens only what the tests wrote.
  const std::string folder = "--user-data-dir=" + profile;
  execl(program.c_str(), program.c_str(), "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic",
        "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--disable-dev-shm-usage", "--remote-debugging-pipe", folder.c_str(), "about:blank",
        static_cast<char*>(nullptr));
  _exit(127);
}

}  // namespace

std::unique_ptr<Browser> Browser::start() {
  const std::string program = find_chromium();
  if (program.empty()) return nullptr;
  int commands[2], answers[2];
  if (pipe2(commands, O_CLOEXEC) != 0 || pipe2(answers, O_CLOEXEC) != 0) return nullptr;
  std::unique_ptr<Browser> browser(new Browser);
  const std::string profile = browser->profile_ / "profile";
  browser->process_ = fork();
  if (browser->process_ == 0) become(program, profile, commands[0], answers[1]);
  close(commands[0]);
  close(answers[1]);
  browser->to_ = commands[1];
  browser->from_ = answers[0];
  signal(SIGPIPE, SIG_IGN);  // a browser that died is a failed call, not the end of the test
  browser->attach();
  return browser;
}

Browser::~Browser() {
  close(to_);
  close(from_);
  if (process_ <= 0) return;
  // The browser leaves when its pipe closes; its process group is our own child's alone.
  const auto deadline = Clock::now() + std::chrono::seconds(5);
  while (waitpid(process_, nullptr, WNOHANG) == 0) {
    if (Clock::now() > deadline) {
      kill(-process_, SIGKILL);
      waitpid(process_, nullptr, 0);
      break;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

void Browser::attach() {
  const json targets = call("Target.getTargets");
  for (const json& target : targets.value("targetInfos", json::array())) {
    if (target["type"] != "page") continue;
    const json attached =
        call("Target.attachToTarget", {{"targetId", target["targetId"]}, {"flatten", true}});
    session_ = attached.value("sessionId", "");
    break;
  }
  for (const char* domain : {"Page", "Runtime", "Log", "Network"}) call(std::string(domain) + ".enable");
}

/// The next message of the browser; null after a minute of silence.
json Browser::receive() {
  const auto deadline = Clock::now() + patience;
  for (;;) {
    if (const std::size_t end = unread_.find('\0'); end != std::string::npos) {
      const json message = json::parse(unread_.substr(0, end), nullptr, false);
      unread_.erase(0, end + 1);
      return message;
    }
    pollfd waiting{from_, POLLIN, 0};
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0 || poll(&waiting, 1, static_cast<int>(left.count())) <= 0) return nullptr;
    char buffer[65536];
    const ssize_t count = read(from_, buffer, sizeof buffer);
    if (count <= 0) return nullptr;
    unread_.append(buffer, static_cast<std::size_t>(count));
  }
}

json Browser::call(const std::string& method, const json& parameters) {
  json request{{"id", ++last_id_}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) request["sessionId"] = session_;
  const std::string text = request.dump() + '\0';
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t count = write(to_, text.data() + sent, text.size() - sent);
    if (count <= 0) {
      ADD_FAILURE() << method << ": the browser is gone";
      return nullptr;
    }
    sent += static_cast<std::size_t>(count);
  }
  for (;;) {
    json message = receive();
    if (!message.is_object()) {
      ADD_FAILURE() << method << ": the browser does not answer";
      return nullptr;
    }
    if (!message.contains("id")) {
      events_.push_back(std::move(message));
    } else if (message["id"] == last_id_) {
      if (message.contains("error")) ADD_FAILURE() << method << ": " << message["error"].dump();
      return message.value("result", json());
    }
  }
}

json Browser::evaluate(const std::string& expression) {
  const json answer =
      call("Runtime.evaluate", {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
  if (!answer.is_object()) return nullptr;
  if (answer.contains("exceptionDetails"))
    ADD_FAILURE() << expression << ": " << answer["exceptionDetails"].dump();
  return answer["result"].value("value", json());
}

void Browser::wait_until(const std::string& expression) {
  const auto deadline = Clock::now() + patience;
  while (evaluate(expression) != true) {
    if (Clock::now() > deadline || ::testing::Test::HasFailure()) {
      ADD_FAILURE() << "never came true: " << expression;
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void Browser::resize(int width, int height) {
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
}

void Browser::open(const std::string& path) {
  events_.clear();
  page_ = "file://" + path;
  call("Page.navigate", {{"url", page_}});
  wait_until("location.protocol === 'file:' && document.readyState === 'complete'");
}

json Browser::rectangle(const std::string& selector) {
  const std::string element = "document.querySelector(" + json(selector).dump() + ")";
  json box = evaluate("(() => { const found = " + element +
                      "; found.scrollIntoView({block: 'center', behavior: 'instant'}); "
                      "const {x, y, width, height} = found.getBoundingClientRect(); "
                      "return {x, y, width, height}; })()");
  if (box.is_object()) return box;
  ADD_FAILURE() << "no element " << selector;
  return {{"x", 0.0}, {"y", 0.0}, {"width", 0.0}, {"height", 0.0}};
}

void Browser::click(const std::string& selector, int times) {
  const json box = rectangle(selector);
  const double x = box["x"].get<double>() + box["width"].get<double>() / 2;
  const double y = box["y"].get<double>() + box["height"].get<double>() / 2;
  for (int count = 1; count <= times; ++count) {
    for (const char* type : {"mousePressed", "mouseReleased"})
      call("Input.dispatchMouseEvent",
           {{"type", type}, {"x", x}, {"y", y}, {"button", "left"}, {"clickCount", count}});
  }
}

void Browser::press(const std::string& key) {
  const int code = key == "ArrowLeft"    ? 37
                   : key == "ArrowRight" ? 39
                   : key == "Home"       ? 36
                   : key == "End"        ? 35
                                         : 0;
  for (const char* type : {"rawKeyDown", "keyUp"}) {
    call("Input.dispatchKeyEvent",
         {{"type", type}, {"key", key}, {"code", key}, {"windowsVirtualKeyCode", code}});
  }
}

void Browser::drag(const std::string& selector, double from_x, double to_x, bool touch) {
  const json box = rectangle(selector);
  const double y = box["y"].get<double>() + box["height"].get<double>() / 2;
  const auto at = [&](double part) { return box["x"].get<double>() + part * box["width"].get<double>(); };
  const auto point = [&](double part) { return json::array({{{"x", at(part)}, {"y", y}}}); };
  if (touch) {
    call("Input.dispatchTouchEvent", {{"type", "touchStart"}, {"touchPoints", point(from_x)}});
    call("Input.dispatchTouchEvent", {{"type", "touchMove"}, {"touchPoints", point((from_x + to_x) / 2)}});
    call("Input.dispatchTouchEvent", {{"type", "touchMove"}, {"touchPoints", point(to_x)}});
    call("Input.dispatchTouchEvent", {{"type", "touchEnd"}, {"touchPoints", json::array()}});
    return;
  }
  const auto mouse = [&](const char* type, double part) {
    call("Input.dispatchMouseEvent",
         {{"type", type}, {"x", at(part)}, {"y", y}, {"button", "left"}, {"buttons", 1}, {"clickCount", 1}});
  };
  mouse("mousePressed", from_x);
  mouse("mouseMoved", to_x);
  mouse("mouseReleased", to_x);
}

std::vector<std::string> Browser::complaints() const {
  std::vector<std::string> found;
  for (const json& event : events_) {
    const std::string method = event.value("method", "");
    const json& told = event["params"];
    if (method == "Runtime.exceptionThrown" || method == "Log.entryAdded" ||
        (method == "Runtime.consoleAPICalled" && (told["type"] == "error" || told["type"] == "warning")))
      found.push_back(method + ": " + told.dump());
  }
  return found;
}

std::vector<std::string> Browser::requests() const {
  std::vector<std::string> found;
  for (const json& event : events_) {
    if (event.value("method", "") != "Network.requestWillBeSent") continue;
    const std::string url = event["params"]["request"]["url"];
    if (url != page_ && !url.starts_with("data:") && !url.starts_with("blob:")) found.push_back(url);
  }
  return found;
}

}  // namespace swept::test
