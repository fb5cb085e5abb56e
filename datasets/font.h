// A 5 × 7 dot-matrix font, drawn for this project.
#pragma once

namespace swept::datasets {

inline constexpr int kGlyphWidth = 5;   ///< dots
inline constexpr int kGlyphHeight = 9;  ///< dots: seven above the base line, two for descenders

/// Whether `letter` has ink at dot (column, row), row 0 at the top. Unknown letters and dots outside
/// the glyph have none.
[[nodiscard]] bool glyph_dot(char letter, int column, int row);

}  // namespace swept::datasets
