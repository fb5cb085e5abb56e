// A printed page in the plane z = 0, facing +z, that may curl about its vertical axis.
#include <sstream>
#include <string>

#include "datasets/font.h"
#include "datasets/paint.h"
#include "datasets/sampling.h"

namespace swept::datasets {
namespace {

constexpr double kHeight = 1.4142135623730951;  // of a sheet of width 1
constexpr double kMargin = 0.09;
constexpr int kPitchX = kGlyphWidth + 1, kPitchY = kGlyphHeight + 2;  // dots from letter to letter

constexpr const char* kTitle = "Swept";
constexpr const char* kText =
    "This page is made of points. Each of them is a small disc of colour that lies on the paper, and the "
    "letters are sharp because there are enough of them. When the page moves while the shutter is open, "
    "every disc draws a streak, and what you see is the sum of all streaks, each cut off where another "
    "passes in front of it. Look at the lines that run across the motion, they fade to grey. Look at the "
    "strokes that run along it, they stay black. An average of many still pictures shows ghosts of every "
    "letter instead. How many would it take to hide them? For text, more than one would like, because "
    "black on white forgives nothing.";

// The text broken into lines of at most `columns` letters, over and over until there are `count`.
std::vector<std::string> set_lines(int columns, int count) {
  std::vector<std::string> lines;
  while (static_cast<int>(lines.size()) < count) {
    std::istringstream words(kText);
    std::string line;
    for (std::string word; words >> word;) {
      if (!line.empty() && static_cast<int>(line.size() + 1 + word.size()) > columns) {
        lines.push_back(line);
        line.clear();
      }
      line += (line.empty() ? "" : " ") + word;
    }
    lines.push_back(line);
    lines.emplace_back();
  }
  lines.resize(static_cast<std::size_t>(count));
  return lines;
}

// Ink of a line of text at a place in dots, x from its left edge, y from its top.
bool inked(const std::string& line, double x, double y) {
  if (x < 0.0 || y < 0.0 || y >= kGlyphHeight) return false;
  const int column = static_cast<int>(x), letter = column / kPitchX;
  if (letter >= static_cast<int>(line.size())) return false;
  return glyph_dot(line[static_cast<std::size_t>(letter)], column % kPitchX, static_cast<int>(y));
}

// All lengths in units of the sheet's width; x from its left edge, y from its top.
class Print {
 public:
  explicit Print(int columns)
      : dot_((1.0 - 2.0 * kMargin) / (columns * kPitchX)),
        body_(kMargin + (kGlyphHeight * kTitleScale + 8.0) * dot_),
        lines_(set_lines(columns, static_cast<int>((kHeight - kMargin - body_) / (dot_ * kPitchY)))) {}

  [[nodiscard]] Eigen::Vector3d color_at(double x, double y) const {
    const Eigen::Vector3d red = srgb(0xb3202a), black = srgb(0x0c0c10);
    const double title_dot = kTitleScale * dot_;
    if (inked(kTitle, (x - kMargin) / title_dot, (y - kMargin) / title_dot)) return red;
    const double above_body = (body_ - y) / dot_;
    if (above_body > 4.0 && above_body < 6.0 && x > kMargin && x < 1.0 - kMargin) return red;
    const double row = (y - body_) / (dot_ * kPitchY);
    if (row >= 0.0 && row < static_cast<double>(lines_.size())) {
      const std::size_t line = static_cast<std::size_t>(row);
      const double within = (row - static_cast<double>(line)) * kPitchY;
      if (inked(lines_[line], (x - kMargin) / dot_, within)) return black;
    }
    return srgb(0xf8f4e9);
  }

 private:
  static constexpr double kTitleScale = 3.0;
  double dot_;   // side of a dot of the text
  double body_;  // where the text begins
  std::vector<std::string> lines_;
};

Result<SurfelCloud> build(const Request& request) {
  const double curl = request.number("curl") * kPi / 180.0;
  const Print print(request.whole("columns"));
  CloudBuilder builder(request);
  builder.add_patch(request.points(), CloudBuilder::Sides::both, [&](double u, double v) {
    const double s = v - 0.5, y = kHeight * (0.5 - u);
    Eigen::Vector3d position(s, y, 0.0), along(1.0, 0.0, 0.0), down(0.0, -kHeight, 0.0);
    if (curl > 1e-9) {  // a cylinder of radius 1/curl, its edges towards +z
      position = {std::sin(curl * s) / curl, y, (1.0 - std::cos(curl * s)) / curl};
      along = {std::cos(curl * s), 0.0, std::sin(curl * s)};
    }
    even_out(down, along);
    return SurfaceSample{position, down, along, print.color_at(v, kHeight * u)};
  });
  return builder.take();
}

}  // namespace

Shape page_shape() {
  return {"page",
          {{"columns", 32, 12, 200, true, "letters to a line"},
           {"curl", 0, 0, 300, false, "degrees by which the sheet is bent from edge to edge"}},
          build};
}

}  // namespace swept::datasets
