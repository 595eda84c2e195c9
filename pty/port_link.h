// A stable name for a pseudo-terminal: a symbolic link where the user wants it.
//
// The kernel reuses /dev/pts numbers at once, so a link's target does not tell whether the bench
// that made it still runs. A lock does: PATH.lock is held (flock) while the link lives, and says
// who holds it and what the link points to.
//
//   PATH            PATH.lock                     then
//   nothing         nothing, or not held          ours
//   our old link    not held (kill -9), names it  taken over
//   anything        held                          refused: another bench runs (its pid is named)
//   anything else   ...                           refused: a file, folder or link that is not ours
#pragma once

#include <string>

#include "pty/file_descriptor.h"

namespace virtdrive {

class PortLink {
 public:
  /// Makes `path` a link to `target`, a terminal that is ours. SetupError, with the remedy, if the
  /// folder is not there or not writable, or the name is another's.
  PortLink(const std::string& path, const std::string& target);
  PortLink(const PortLink&) = delete;
  PortLink& operator=(const PortLink&) = delete;
  /// Removes the link if it still is what we made, and the lock.
  ~PortLink();

  /// Absolute.
  const std::string& path() const { return path_; }

 private:
  void make_link();
  void remove_lock();

  std::string path_;
  std::string target_;
  FileDescriptor lock_;
};

}  // namespace virtdrive
