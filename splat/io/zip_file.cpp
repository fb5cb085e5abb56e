#include "splat/io/zip_file.h"

#include <algorithm>

#include <zip.h>

namespace swept::io {
namespace {

Error failed(zip_error_t& error) {
  const std::string reason = zip_error_strerror(&error);
  zip_error_fini(&error);
  return {"", "", "its zip archive cannot be read: " + reason};
}

Error failed_in(zip_t* archive) {
  return {"", "", std::string("cannot be read from the zip archive: ") + zip_strerror(archive)};
}

}  // namespace

void ZipFile::Close::operator()(void* archive) const { zip_discard(static_cast<zip_t*>(archive)); }

Result<ZipFile> ZipFile::open(std::string_view bytes) {
  zip_error_t error;
  zip_error_init(&error);
  zip_source_t* const source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
  if (!source) return failed(error);
  zip_t* const archive = zip_open_from_source(source, ZIP_RDONLY | ZIP_CHECKCONS, &error);
  if (!archive) {
    zip_source_free(source);
    return failed(error);
  }
  zip_error_fini(&error);
  return ZipFile(archive);
}

Result<std::string> ZipFile::read(const std::string& name, std::size_t most) const {
  auto* const archive = static_cast<zip_t*>(archive_.get());
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_stat(archive, name.c_str(), 0, &stat) != 0) return failed_in(archive);
  constexpr zip_uint64_t needed = ZIP_STAT_SIZE | ZIP_STAT_COMP_METHOD;
  if ((stat.valid & needed) != needed) return Error{"", "", "the zip archive does not say its size"};
  if (stat.comp_method != ZIP_CM_STORE && stat.comp_method != ZIP_CM_DEFLATE)
    return Error{"", "",
                 "is packed by zip method " + std::to_string(stat.comp_method) + "; 0 and 8 are known",
                 ErrorKind::unsupported};
  if (stat.size > most)
    return Error{"", "",
                 "has " + std::to_string(stat.size) + " bytes, more than the " + std::to_string(most) +
                     " that there may be"};
  const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(zip_fopen(archive, name.c_str(), 0),
                                                               zip_fclose);
  if (!file) return failed_in(archive);
  std::string bytes;
  std::size_t have = 0;
  while (true) {
    // Memory grows with what comes, whatever size was promised; one byte beyond it tells that there is more.
    bytes.resize(std::min(static_cast<std::size_t>(stat.size) + 1, std::max(have + 1, 2 * have + (1 << 16))));
    const zip_int64_t came = zip_fread(file.get(), bytes.data() + have, bytes.size() - have);
    if (came < 0)
      return Error{"", "",
                   std::string("cannot be read from the zip archive: ") + zip_file_strerror(file.get())};
    if (came == 0) break;
    have += static_cast<std::size_t>(came);
    if (have > stat.size) break;
  }
  if (have != stat.size)
    return Error{"", "",
                 "does not have the " + std::to_string(stat.size) + " bytes that the zip archive promises"};
  bytes.resize(have);
  return bytes;
}

}  // namespace swept::io
