// A serial port as a host program has it: the other side of what this project emulates. For our own
// client and for tests; works on a real serial port too.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/host_transport.h"
#include "pty/file_descriptor.h"

namespace virtdrive {

class HostPort final : public HostTransport {
 public:
  /// Opens `path` raw, 8N1, at `baud` bit/s. SetupError if it cannot be opened or is no terminal.
  HostPort(const std::string& path, int baud);

  /// Writes all bytes. SetupError if the port takes none for a second, or is gone.
  void write(std::span<const std::uint8_t> bytes) override;

  /// Waits until `count` bytes have come, or the time is over: then returns what has come.
  /// SetupError if the port is gone.
  std::vector<std::uint8_t> read(std::size_t count, std::chrono::nanoseconds timeout);
  /// The next byte, of the wall clock's time.
  std::optional<std::uint8_t> read(SimDuration patience) override;

  int fd() const { return tty_.get(); }

 private:
  std::string path_;
  FileDescriptor tty_;
};

}  // namespace virtdrive
