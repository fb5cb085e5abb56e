#include "splat/io/atomic_file.h"
#include "splat/io/guarded.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

namespace swept {
namespace {

// So many processes writing one path at once have another problem.
constexpr int kMostTemporaries = 10000;

/// The names that remove_temporaries() needs, where a signal handler may read them. The one thing here that
/// outlives a call; a temporary too many, or with too long a name, is only not removed by a signal.
struct NameSlot {
  std::atomic<bool> taken{false}, named{false};
  char name[PATH_MAX];
};
NameSlot name_slots[16];

int take_slot(const std::string& name) {
  if (name.size() >= sizeof NameSlot::name) return -1;
  for (std::size_t i = 0; i < std::size(name_slots); ++i) {
    NameSlot& slot = name_slots[i];
    if (slot.taken.exchange(true)) continue;
    std::memcpy(slot.name, name.c_str(), name.size() + 1);
    slot.named = true;
    return static_cast<int>(i);
  }
  return -1;
}

void free_slot(int slot) {
  if (slot < 0) return;
  name_slots[slot].named = false;
  name_slots[slot].taken = false;
}

Error system_error(const std::string& path, const char* what, int code) {
  return {path, "", std::string(what) + ": " + std::generic_category().message(code),
          code == ENOENT ? ErrorKind::not_found : ErrorKind::device};
}

/// Where writing to `path` writes to: the end of the links, of which the last may lead nowhere yet.
Result<std::string> target_of(const std::string& path) {
  namespace fs = std::filesystem;
  constexpr int most_links = 40;  // as many as the kernel follows
  fs::path target = path;
  for (int i = 0; i < most_links; ++i) {
    struct stat status {};
    if (lstat(target.c_str(), &status) != 0) {
      if (errno != ENOENT) return system_error(path, "cannot be written", errno);
      return target.string();
    }
    if (S_ISDIR(status.st_mode))
      return Error{path, "", "cannot be written: it is a folder", ErrorKind::device};
    if (S_ISREG(status.st_mode)) return target.string();
    if (!S_ISLNK(status.st_mode))
      return Error{path, "", "cannot be written: it is a pipe or a device, and not a file",
                   ErrorKind::device};
    std::error_code code;
    const fs::path next = fs::read_symlink(target, code);
    if (code) return system_error(path, "cannot be written", code.value());
    target = next.is_absolute() ? next : target.parent_path() / next;
  }
  return system_error(path, "cannot be written", ELOOP);
}

/// Whether `name` is still the file that is open as `descriptor`.
bool same_file(const std::string& name, int descriptor) {
  struct stat by_name {
  }, open{};
  return stat(name.c_str(), &by_name) == 0 && fstat(descriptor, &open) == 0 &&
         by_name.st_dev == open.st_dev && by_name.st_ino == open.st_ino;
}

/// Removes a temporary that nobody writes: writers hold a lock on theirs, and who dies loses it.
bool remove_abandoned(const std::string& name) {
  const int descriptor = open(name.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (descriptor < 0) return false;
  const bool abandoned =
      flock(descriptor, LOCK_EX | LOCK_NB) == 0 && same_file(name, descriptor) && unlink(name.c_str()) == 0;
  close(descriptor);
  return abandoned;
}

/// 0, or errno.
int rename_over(const std::string& from, const std::string& to) {
  return std::rename(from.c_str(), to.c_str()) == 0 ? 0 : errno;
}

/// Renames unless there is a file of the new name. 0, or errno.
int rename_to_new(const std::string& from, const std::string& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  // Not every file system knows how.
  if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP) return errno;
  if (link(from.c_str(), to.c_str()) != 0) return errno;
  unlink(from.c_str());
  return 0;
}

}  // namespace

AtomicFile::AtomicFile(AtomicFile&& other) noexcept
    : path_(std::exchange(other.path_, {})),
      target_(std::exchange(other.target_, {})),
      temporary_(std::exchange(other.temporary_, {})),
      stream_(std::exchange(other.stream_, nullptr)),
      slot_(std::exchange(other.slot_, -1)) {}

AtomicFile& AtomicFile::operator=(AtomicFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(target_, other.target_);
  std::swap(temporary_, other.temporary_);
  std::swap(stream_, other.stream_);
  std::swap(slot_, other.slot_);
  return *this;
}

AtomicFile::~AtomicFile() { discard(); }

Error AtomicFile::error(const char* what, int code) const { return system_error(path_, what, code); }

void AtomicFile::discard() {
  if (!temporary_.empty()) std::remove(std::exchange(temporary_, {}).c_str());
  if (stream_ != nullptr) std::fclose(std::exchange(stream_, nullptr));
  free_slot(std::exchange(slot_, -1));
}

/// Opens `name` if it is free, or abandoned; else errno says why not.
bool AtomicFile::try_name(const std::string& name) {
  constexpr mode_t all = 0666;  // less what the umask takes
  struct stat status {};
  if (lstat(name.c_str(), &status) == 0 && !remove_abandoned(name)) {
    errno = EEXIST;
    return false;
  }
  // Listed before it is there, so that no signal comes between.
  const int slot = take_slot(name);
  const int descriptor = open(name.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, all);
  int code = descriptor < 0 ? errno : 0;
  // Locks fail where the file system has none; then nothing is ever taken for abandoned either.
  if (code == 0 &&
      ((flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) || !same_file(name, descriptor)))
    code = EEXIST;  // someone found it before it was locked, and takes it away
  if (code == 0 && (stream_ = fdopen(descriptor, "w+b")) == nullptr) {
    code = errno;
    unlink(name.c_str());
  }
  if (code == 0) {
    temporary_ = name;
    slot_ = slot;
    return true;
  }
  free_slot(slot);
  if (descriptor >= 0) close(descriptor);
  errno = code;
  return false;
}

Result<AtomicFile> AtomicFile::create(const std::string& path) {
  return io::guarded(path, [&]() -> Result<AtomicFile> {
    if (path.empty()) return Error{"", "path", "an output file needs a name"};
    if (path.find('\0') != std::string::npos)
      return Error{path, "path", "has a null character, at which the system would end it",
                   ErrorKind::argument};
    Result<std::string> target = target_of(path);
    if (!target) return target.error();
    AtomicFile file;
    file.path_ = path;
    file.target_ = std::move(*target);
    std::string stem = file.target_;
    for (int n = 0; n < kMostTemporaries; ++n) {
      if (file.try_name(stem + ".tmp" + std::to_string(n))) return file;
      if (errno == ENAMETOOLONG && stem == file.target_) {
        stem = (std::filesystem::path(file.target_).parent_path() / ".swept").string();
        n = -1;
        continue;
      }
      if (errno == ENOENT)
        return Error{path, "",
                     "cannot be written: there is no folder " +
                         std::filesystem::path(file.target_).parent_path().string(),
                     ErrorKind::not_found};
      if (errno != EEXIST) return file.error("cannot be written", errno);
    }
    return Error{path, "", "cannot be written: its folder is full of temporary files " + stem + ".tmpN",
                 ErrorKind::device};
  });
}

Status AtomicFile::commit(IfExists existing) {
  return io::guarded(path_, [&]() -> Status {
    // A write that failed earlier has left its errno behind long ago.
    const bool written = std::ferror(stream_) == 0;
    // Closed first, where some file systems say that they are full, and locked until the rename all the same.
    const int lock = fcntl(fileno(stream_), F_DUPFD_CLOEXEC, 0);
    errno = 0;
    const bool closed = std::fclose(std::exchange(stream_, nullptr)) == 0;
    int code = errno;
    if (written && closed) {
      code =
          existing == IfExists::fail ? rename_to_new(temporary_, target_) : rename_over(temporary_, target_);
      if (code == 0) temporary_.clear();
    }
    discard();
    if (lock >= 0) close(lock);
    if (!closed) return error("cannot be written", code);
    if (!written) return Error{path_, "", "not all of it could be written; is the disk full?"};
    if (code == EEXIST)
      return Error{path_, "", "appeared while it was being written, and is kept", ErrorKind::device};
    if (code != 0) return error("cannot be put in place", code);
    return Done{};
  });
}

Status write_file(const std::string& path, std::string_view content) {
  return io::guarded(path, [&]() -> Status {
    Result<AtomicFile> file = AtomicFile::create(path);
    if (!file) return file.error();
    // A short write sets the stream's error, which commit reports.
    std::fwrite(content.data(), 1, content.size(), file->stream());
    return file->commit();
  });
}

void remove_temporaries() noexcept {
  for (const NameSlot& slot : name_slots)
    if (slot.named) unlink(slot.name);
}

}  // namespace swept
