// A host inside the simulation: it writes to the line and lets simulated time pass while it waits.
#pragma once

#include <deque>

#include "core/event_loop.h"
#include "devices/host_transport.h"
#include "pty/serial_line.h"

namespace virtdrive {

class LineTransport final : public HostTransport {
 public:
  /// Listens at the line's host end, in place of who did, until it is destroyed.
  LineTransport(EventLoop& loop, SerialLine& line);
  ~LineTransport() override;
  LineTransport(const LineTransport&) = delete;
  LineTransport& operator=(const LineTransport&) = delete;

  void write(std::span<const std::uint8_t> bytes) override;
  std::optional<std::uint8_t> read(SimDuration patience) override;

 private:
  EventLoop& loop_;
  SerialLine& line_;
  SerialLine::HostListener before_;
  std::deque<std::uint8_t> heard_;
};

}  // namespace virtdrive
