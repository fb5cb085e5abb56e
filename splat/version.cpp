#include <swept/version.h>

namespace swept {

const char* version() noexcept { return SWEPT_VERSION_STRING; }

}  // namespace swept
