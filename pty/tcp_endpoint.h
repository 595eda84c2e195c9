// A TCP port at the host end of a line: for hosts on another machine, in a container, on Windows.
//
//   raw        the bytes as they are (pyserial's socket://, socat, nc)
//   RFC 2217   telnet that carries baud rate, size, parity and stop bits as well (pyserial's
//              rfc2217://, COM port redirectors); see Rfc2217Session
//
// One client at a time: who comes while another is there is accepted and closed. A client that has
// said its last word (a half-closed connection, and a closed one looks the same) still hears the
// drive, until the next client comes or it turns out to be gone.
//
// Nothing here waits for a client: what it does not read is lost once the kernel's buffers and ours
// are full, and counted. There is no password: the port is open on the loopback interface only,
// unless another address is named.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "pty/file_descriptor.h"
#include "pty/host_endpoint.h"
#include "pty/rfc2217_session.h"
#include "pty/serial_line.h"

namespace virtdrive {

enum class TcpMode : std::uint8_t { kRaw, kRfc2217 };

struct TcpCounters {
  std::uint64_t attached = 0;  // clients served
  std::uint64_t refused = 0;   // clients that came while another was there
  std::uint64_t unheard = 0;   // bytes from the device while nobody was there
  std::uint64_t overrun = 0;   // bytes lost because the client did not read
  std::uint64_t ignored = 0;   // RFC 2217 commands that were malformed or unknown
};

class TcpEndpoint final : public HostEndpoint {
 public:
  /// Bytes of the device held for a client beyond what is on its way.
  static constexpr std::size_t kMaxPending = 4096;
  /// Bytes taken from the client before they have left: the client waits behind them.
  static constexpr std::size_t kMaxBacklog = 4096;

  /// Listens at `address`: HOST:PORT, [IPv6]:PORT, or PORT alone for 127.0.0.1; port 0: the kernel
  /// chooses a free one. The line must outlive the endpoint. SetupError if the address is none, or
  /// cannot be had.
  TcpEndpoint(SerialLine& line, const std::string& address, TcpMode mode);
  TcpEndpoint(const TcpEndpoint&) = delete;
  TcpEndpoint& operator=(const TcpEndpoint&) = delete;
  ~TcpEndpoint() override;

  int fd() const override { return epoll_.get(); }
  void readable() override;
  void flush() override;

  /// Where a client finds us: "127.0.0.1:5555", "[::1]:5555".
  const std::string& address() const { return address_; }
  /// A client is there and has not said its last word.
  bool attached() const { return client_ && !finished_; }
  const TcpCounters& counters() const { return counters_; }

 private:
  void read_client();
  void accept_clients();
  void session_begins(FileDescriptor client);
  void session_ends();
  void rearm();

  SerialLine& line_;
  TcpMode mode_;
  FileDescriptor listener_;
  FileDescriptor client_;
  FileDescriptor epoll_;  // of listener_ and client_
  std::string address_;
  ClientOutbox outbox_;
  std::optional<Rfc2217Session> session_;
  bool finished_ = false;    // the client will send nothing more
  std::uint32_t armed_ = 0;  // epoll events asked of the client
  TcpCounters counters_;
};

}  // namespace virtdrive
