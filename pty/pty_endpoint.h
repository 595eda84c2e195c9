// A pseudo-terminal at the host end of a line: what a host program opens instead of /dev/ttyUSB0.
//
// The terminal is raw and set to the line's baud rate before anyone can know its name, so bytes
// pass unchanged even for programs that set nothing. We keep its slave side open ourselves, so that
// it lives on while nobody is there. inotify tells of every open and close; where counting them
// leaves a doubt, our own descriptor is dropped for a moment, which shows at the master whether
// anyone is left.
//
//   nobody -> a host   what an earlier host left unread is thrown away
//   a host -> nobody   settings go back to the preset, TIOCEXCL is lifted
//
// Nothing here waits for a host: what it does not read is lost once the kernel's queue and
// kMaxPending bytes are full, and counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "pty/file_descriptor.h"
#include "pty/host_endpoint.h"
#include "pty/port_link.h"
#include "pty/serial_line.h"
#include "pty/tty_settings.h"

namespace virtdrive {

struct PtyCounters {
  std::uint64_t attached = 0;  // times a first host came
  std::uint64_t unheard = 0;   // bytes from the device while nobody was there
  std::uint64_t overrun = 0;   // bytes lost because the host did not read
};

class PtyEndpoint final : public HostEndpoint {
 public:
  /// Bytes held for a host beyond what the kernel holds (13 to 21 kB, measured on Linux 6.18).
  static constexpr std::size_t kMaxPending = 4096;
  /// Bytes taken from the host before they have left: the host's write() blocks behind them, as it
  /// does behind the 4096-byte transmit buffer of a Linux serial driver.
  static constexpr std::size_t kMaxBacklog = 4096;

  /// Opens a pseudo-terminal and, if `link` is not empty, a stable name for it. The line must
  /// outlive the endpoint. SetupError if the system has no pseudo-terminal left or the name cannot
  /// be had.
  explicit PtyEndpoint(SerialLine& line, const std::string& link = "");
  PtyEndpoint(const PtyEndpoint&) = delete;
  PtyEndpoint& operator=(const PtyEndpoint&) = delete;
  ~PtyEndpoint() override;

  int fd() const override { return epoll_.get(); }
  void readable() override;
  void flush() override;

  /// What a host opens: the link if there is one, else the terminal (/dev/pts/N).
  const std::string& path() const;
  const std::string& terminal() const { return terminal_; }
  bool attached() const { return attached_; }
  const PtyCounters& counters() const { return counters_; }

 private:
  struct Hints {
    int opened = 0;
    int closed = 0;
    bool emptied = false;   // only our own descriptor was left at some moment
    bool overflow = false;  // anything may have happened
  };

  Hints read_hints();
  bool read_host();
  void update_attachment(bool present, bool anew);
  bool in_doubt(const Hints& hints, bool spoken) const;
  bool host_present();
  void open_slave();
  void session_begins();
  void session_ends();
  void preset();
  void refresh_host_settings();
  void rearm();

  SerialLine& line_;
  FileDescriptor master_;
  FileDescriptor slave_;  // keeps the terminal alive while nobody is there
  FileDescriptor inotify_;
  FileDescriptor epoll_;  // of master_ and inotify_
  std::string terminal_;
  std::unique_ptr<PortLink> link_;
  TtySettings preset_;         // the line's own
  TtySettings host_settings_;  // as last seen at the master
  int terminal_watch_ = -1;
  int open_count_ = 1;  // of the slave, our own included, as inotify tells it
  bool attached_ = false;
  std::uint32_t armed_ = 0;  // epoll events asked of the master
  std::vector<std::uint8_t> pending_;
  PtyCounters counters_;
};

}  // namespace virtdrive
