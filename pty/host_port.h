// A serial port as a host program has it: the other side of what this project emulates. For our own
// clients and for tests; works on a real serial port too, and on a port behind TCP.
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
#include "pty/tty_settings.h"

namespace virtdrive {

class HostPort final : public HostTransport {
 public:
  /// Opens `address`, the path of a terminal, raw and set so, or "tcp://HOST:PORT", where bytes are
  /// all there is. SetupError if it cannot be opened or is no terminal.
  HostPort(const std::string& address, const TtySettings& settings);
  /// 8N1.
  HostPort(const std::string& address, int baud) : HostPort(address, TtySettings{.baud = baud}) {}

  /// Writes all bytes. SetupError if the port takes none for a second, or is gone.
  void write(std::span<const std::uint8_t> bytes) override;

  /// Waits until `count` bytes have come, or the time is over: then returns what has come.
  /// SetupError if the port is gone.
  std::vector<std::uint8_t> read(std::size_t count, std::chrono::nanoseconds timeout);
  /// The next byte, of the wall clock's time.
  std::optional<std::uint8_t> read(SimDuration patience) override;

  /// Once what was written has left; nothing to do behind TCP. SetupError if it cannot be set so.
  void set(const TtySettings& settings);

  /// Of the wall clock.
  std::chrono::nanoseconds since_open() const { return std::chrono::steady_clock::now() - opened_; }

  int fd() const { return port_.get(); }

 private:
  std::string address_;
  FileDescriptor port_;
  std::chrono::steady_clock::time_point opened_ = std::chrono::steady_clock::now();
};

}  // namespace virtdrive
