#include "pty/port_link.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <optional>
#include <sys/file.h>
#include <sys/stat.h>

#include "core/check.h"

namespace virtdrive {
namespace {

// A lock file is one line: "virtdrive 1234 /dev/pts/5".
constexpr std::string_view kMark = "virtdrive ";

struct Owner {
  std::string pid;
  std::string target;
};

std::string read_all(int fd) {
  std::array<char, 512> text{};
  const ssize_t size = pread(fd, text.data(), text.size(), 0);
  return {text.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
}

/// Nothing if the lock file is not one of ours.
std::optional<Owner> parse_owner(const std::string& text) {
  if (text.empty()) return Owner{};  // its maker was killed before it could write
  if (!text.starts_with(kMark) || text.back() != '\n') return std::nullopt;
  const std::size_t space = text.find(' ', kMark.size());
  if (space == std::string::npos) return std::nullopt;
  return Owner{text.substr(kMark.size(), space - kMark.size()),
               text.substr(space + 1, text.size() - space - 2)};
}

bool same_file(int fd, const std::string& path) {
  struct stat open_file{};
  struct stat named{};
  return fstat(fd, &open_file) == 0 && lstat(path.c_str(), &named) == 0 &&
         open_file.st_dev == named.st_dev && open_file.st_ino == named.st_ino;
}

/// What the link points to; empty if there is no link at `path`.
std::string link_target(const std::string& path) {
  std::array<char, 4096> target{};
  const ssize_t size = readlink(path.c_str(), target.data(), target.size());
  return {target.data(), size > 0 ? static_cast<std::size_t>(size) : 0};
}

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
  throw SetupError(fmt::format("cannot name the port '{}': {}", path, why));
}

[[noreturn]] void refuse_folder(const std::string& path, int error) {
  const std::string folder = std::filesystem::path(path).parent_path();
  if (error == ENOENT) {
    refuse(path, fmt::format("there is no folder '{0}'; make it (mkdir -p '{0}') or choose "
                             "another name",
                             folder));
  }
  if (error == ENOTDIR) {
    refuse(path, fmt::format("'{}' is not a folder; choose another name", folder));
  }
  if (error == EACCES || error == EPERM || error == EROFS) {
    refuse(path, fmt::format("folder '{}' is not writable for you; choose a name in one that is",
                             folder));
  }
  refuse(path, fmt::format("{}; choose another name", std::strerror(error)));
}

/// Opens and locks PATH.lock. Another bench that just ended may remove the file between our opening
/// and locking it: then it is opened anew.
FileDescriptor take_lock(const std::string& path) {
  const std::string lock_path = path + ".lock";
  for (;;) {
    FileDescriptor lock{
        ::open(lock_path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0644)};
    if (!lock) {
      const int error = errno;
      struct stat other{};
      if (lstat(lock_path.c_str(), &other) == 0) {
        refuse(path, fmt::format("'{}' cannot be opened ({}); remove it or choose another name",
                                 lock_path, std::strerror(error)));
      }
      refuse_folder(path, error);
    }
    const std::optional<Owner> owner = parse_owner(read_all(lock.get()));
    if (!owner) {
      refuse(path, fmt::format("'{}' is there and is not a lock of virtdrive; move it away or "
                               "choose another name",
                               lock_path));
    }
    if (flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
      refuse(path, fmt::format("a running bench has it (process {}); stop that one or choose "
                               "another name",
                               owner->pid.empty() ? "just started" : owner->pid));
    }
    if (same_file(lock.get(), lock_path)) return lock;
  }
}

void write_owner(int lock, const std::string& path, const std::string& target) {
  const std::string line = fmt::format("{}{} {}\n", kMark, getpid(), target);
  if (ftruncate(lock, 0) != 0 ||
      pwrite(lock, line.data(), line.size(), 0) != static_cast<ssize_t>(line.size())) {
    refuse(path, fmt::format("'{}.lock' cannot be written: {}", path, std::strerror(errno)));
  }
}

}  // namespace

PortLink::PortLink(const std::string& path, const std::string& target) : target_(target) {
  const std::filesystem::path absolute = std::filesystem::absolute(path).lexically_normal();
  path_ = absolute;
  if (!absolute.has_filename()) refuse(path_, "it names a folder; name a file in it");
  lock_ = take_lock(path_);
  try {
    make_link();
  } catch (const SetupError&) {
    remove_lock();
    throw;
  }
}

PortLink::~PortLink() {
  if (link_target(path_) == target_) unlink(path_.c_str());
  remove_lock();
}

void PortLink::make_link() {
  const std::string stale = parse_owner(read_all(lock_.get()))->target;
  struct stat there{};
  if (lstat(path_.c_str(), &there) == 0) {
    const bool ours = S_ISLNK(there.st_mode) && !stale.empty() && link_target(path_) == stale;
    if (!ours) {
      const char* kind = S_ISLNK(there.st_mode)   ? "a link"
                         : S_ISDIR(there.st_mode) ? "a folder"
                                                  : "a file";
      refuse(path_, fmt::format("{} that virtdrive did not make is there; remove it or choose "
                                "another name",
                                kind));
    }
    unlink(path_.c_str());
  }
  write_owner(lock_.get(), path_, target_);
  if (symlink(target_.c_str(), path_.c_str()) != 0) refuse_folder(path_, errno);
}

void PortLink::remove_lock() {
  const std::string lock_path = path_ + ".lock";
  if (same_file(lock_.get(), lock_path)) unlink(lock_path.c_str());
}

}  // namespace virtdrive
