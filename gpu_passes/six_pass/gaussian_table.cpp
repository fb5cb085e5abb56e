#include "gpu_passes/six_pass/gaussian_table.h"

#include <cmath>
#include <vector>

namespace swept {

GlTexture make_gaussian_table() {
  std::vector<float> entries;
  entries.reserve(2 * table_texels);
  for (int i = 0; i < table_texels; ++i) {
    const double y = static_cast<double>(table_range) * i / (table_texels - 1);
    entries.push_back(static_cast<float>(std::exp(-y * y)));
    entries.push_back(static_cast<float>(std::erf(y)));
  }
  GlTexture table = GlTexture::make();
  glBindTexture(GL_TEXTURE_2D, table.name());
  glTexStorage2D(GL_TEXTURE_2D, 1, GL_RG32F, table_texels, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, table_texels, 1, GL_RG, GL_FLOAT, entries.data());
  for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTexParameteri(GL_TEXTURE_2D, filter, GL_LINEAR);
  for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
  glBindTexture(GL_TEXTURE_2D, 0);
  return table;
}

}  // namespace swept
