// How much of a place's light is left over its exposure, layer by layer: spans, over each of which it is
// even, or a smooth function where what takes it is uneven.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "abuffer/resolve/smooth_part.h"
#include "splat/interval/composite.h"

namespace swept {

/// A thread's. Times are shares of the row's light.
class LightLeft {
 public:
  /// A part of a span.
  struct Part {
    double begin, end;
    bool is_even;
    double even;         ///< what is left, where it is
    SmoothPart changes;  ///< and where it is not

    [[nodiscard]] double span() const { return end - begin; }
    [[nodiscard]] double at(std::size_t point) const { return is_even ? even : changes.v[point]; }
    /// From `from` to `to`, which are within it.
    [[nodiscard]] Part between(double from, double to) const {
      Part part;
      part.begin = from, part.end = to, part.is_even = is_even, part.even = even;
      if (!is_even)
        part.changes = from == begin && to == end
                           ? changes
                           : changes.part((from - begin) / span(), (to - begin) / span());
      return part;
    }
  };

  /// All of it is left.
  void start() {
    spans_.assign(1, {1.0, 1.0, none});
    changes_.clear();
  }
  /// Calls take(part) for the parts of [from, to] in which there is light, in order: it has to leave() each,
  /// whole or in parts that follow each other. Returns whether any light is left after that.
  template <class Take>
  bool meet(double from, double to, const Take& take) {
    next_.clear();
    lit_ = false;
    double begin = 0.0;
    for (const Span& span : spans_) {
      const double first = std::max(begin, from), last = std::min(span.end, to);
      if (!(first < last)) {
        put(span);
      } else if (span.changes == none) {
        if (begin < first) put({first, span.left, none});
        if (span.left > 0.0) {
          Part part;
          part.begin = first, part.end = last, part.is_even = true, part.even = span.left;
          take(part);
        } else {
          put({last, 0.0, none});
        }
        if (last < span.end) put(span);
      } else {
        const Part whole{begin, span.end, false, 0.0, changes_[span.changes]};
        if (begin < first) leave(first, whole.between(begin, first).changes);
        take(whole.between(first, last));
        if (last < span.end) leave(span.end, whole.between(last, span.end).changes);
      }
      begin = span.end;
    }
    spans_.swap(next_);
    return lit_;
  }
  /// Of meet(): so much is left up to `end`.
  void leave(double end, double left) { put({end, left < double{opaque_transmittance} ? 0.0 : left, none}); }
  void leave(double end, SmoothPart left) {
    if (*std::max_element(left.v.begin(), left.v.end()) < double{opaque_transmittance})
      return put({end, 0.0, none});
    put({end, 0.0, static_cast<std::uint32_t>(changes_.size())});
    // Where hardly any is left rounding may take more.
    for (double& v : left.v) v = std::max(0.0, v);
    changes_.push_back(left);
  }

 private:
  static constexpr std::uint32_t none = ~0u;
  /// From where the one before ends.
  struct Span {
    double end, left;
    std::uint32_t changes;  ///< of changes_; none: it is even
  };

  void put(const Span& span) {
    lit_ = lit_ || span.changes != none || span.left > 0.0;
    if (!next_.empty() && span.changes == none && next_.back().changes == none &&
        next_.back().left == span.left)
      next_.back().end = span.end;
    else
      next_.push_back(span);
  }

  std::vector<Span> spans_, next_;
  std::vector<SmoothPart> changes_;
  bool lit_ = false;
};

}  // namespace swept
