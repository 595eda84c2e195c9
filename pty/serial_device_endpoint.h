// A real serial port at the host end of a line: the emulator at the end of a real wire, in the
// drive's place, with the host program on another machine (or on another adapter of this one).
//
// The port is set raw to the line's baud rate, size, parity and stop bits, follows the drive when
// it changes its baud rate, and gets its own settings back at the end. Nobody else may have it
// meanwhile. Bytes that fail the parity check are dropped by the kernel.
//
// The line keeps its character times in both directions. The UART adds one of its own at each end,
// since it, too, hands a byte over only when its last bit is through: a reply comes two character
// times later than from a drive (174 us at 115200 baud), but the drive hears the bytes of a burst
// spaced as they were, although an adapter hands them over in one piece, and its transmitter is
// busy for as long as it should be. On an ideal line the UART alone paces what goes out. Only a
// simulation paced at real time makes sense here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pty/file_descriptor.h"
#include "pty/host_endpoint.h"
#include "pty/serial_line.h"
#include "pty/tty_settings.h"

namespace virtdrive {

struct SerialDeviceCounters {
  std::uint64_t overrun = 0;  // bytes lost because the port took no more
};

class SerialDeviceEndpoint final : public HostEndpoint {
 public:
  /// Bytes held for the port beyond what the kernel holds.
  static constexpr std::size_t kMaxPending = 4096;
  /// Bytes taken from the port before they have arrived; more wait in the kernel.
  static constexpr std::size_t kMaxBacklog = 4096;

  /// The line must outlive the endpoint. SetupError if `path` is no serial port, may not be opened,
  /// is in use, or cannot be set as the line is.
  SerialDeviceEndpoint(SerialLine& line, const std::string& path);
  SerialDeviceEndpoint(const SerialDeviceEndpoint&) = delete;
  SerialDeviceEndpoint& operator=(const SerialDeviceEndpoint&) = delete;
  ~SerialDeviceEndpoint() override;

  int fd() const override { return epoll_.get(); }
  /// SetupError when the port is gone (unplugged).
  void readable() override;
  /// SetupError if the drive has changed to a baud rate that the port cannot have.
  void flush() override;

  const std::string& path() const { return path_; }
  bool alive() const { return alive_; }
  const SerialDeviceCounters& counters() const { return counters_; }

 private:
  void read_port();
  void write_port();
  void apply_settings();
  void rearm();

  SerialLine& line_;
  std::string path_;
  FileDescriptor port_;
  FileDescriptor epoll_;
  std::shared_ptr<const termios2> found_;  // the settings before ours
  TtySettings settings_;
  bool alive_ = true;
  std::uint32_t armed_ = 0;  // epoll events asked of the port
  std::vector<std::uint8_t> pending_;
  SerialDeviceCounters counters_;
};

}  // namespace virtdrive
