// A forked copy of a test that does something and tells its parent; never outlives its deadline.
#pragma once

#include <csignal>
#include <functional>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/check.h"
#include "pty/file_descriptor.h"

namespace virtdrive {

class ChildProcess {
 public:
  /// Runs `work` in a child, which calls its argument once it is ready, and exits with what it
  /// returns (99 if it throws). Returns when the child is ready or gone.
  explicit ChildProcess(const std::function<int(const std::function<void()>& ready)>& work) {
    int ends[2];
    VIRTDRIVE_CHECK(pipe(ends) == 0, "pipe");
    FileDescriptor reader{ends[0]};
    FileDescriptor writer{ends[1]};
    pid_ = fork();
    VIRTDRIVE_CHECK(pid_ >= 0, "fork");
    if (pid_ == 0) {
      alarm(kDeadlineSeconds);
      int code = 99;
      try {
        code = work([&] { [[maybe_unused]] const ssize_t n = ::write(writer.get(), "r", 1); });
      } catch (...) {
      }
      _exit(code);
    }
    writer.reset();
    char byte = 0;
    ready_ = ::read(reader.get(), &byte, 1) == 1;
  }
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess() {
    if (pid_ > 0) end(SIGKILL);
  }

  bool ready() const { return ready_; }
  pid_t pid() const { return pid_; }
  /// Sends the signal and waits; the child's wait status.
  int end(int signal) {
    kill(pid_, signal);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = 0;
    return status;
  }

 private:
  static constexpr unsigned kDeadlineSeconds = 30;

  pid_t pid_ = 0;
  bool ready_ = false;
};

}  // namespace virtdrive
