// What turns primitives of one kind into fragments, tile by tile. For the project's own sources.
#pragma once

#include <cstddef>

#include "abuffer/sources/rasterize.h"

namespace swept {

/// One thread's. It keeps its memory from tile to tile. Who resolves its fragments knows of which kind they
/// are.
class FragmentSource {
 public:
  virtual ~FragmentSource() = default;
  FragmentSource(const FragmentSource&) = delete;
  FragmentSource& operator=(const FragmentSource&) = delete;

  /// Chooses the primitives that may come by the tile.
  virtual void select(std::size_t tile) = 0;
  /// Replaces its fragments by those of a window of that tile, sorted by pixel. False: they are more than may
  /// be held at once; then the caller asks for halves. A window of one pixel always fits.
  [[nodiscard]] virtual bool gather(const Window& window) = 0;

 protected:
  FragmentSource() = default;
  FragmentSource(FragmentSource&&) = default;
};

}  // namespace swept
