// Listens to a line, cuts what passes into packets, and tells its sinks of them and of what the
// host did.
#pragma once

#include <string_view>
#include <vector>

#include "core/event_loop.h"
#include "pty/serial_line.h"
#include "scenarios/recording/frame_cutter.h"
#include "scenarios/recording/wire_sink.h"

namespace virtdrive {

class LineMonitor {
 public:
  /// `line_number` is what the sinks are told; `protocol` is a table's name. Takes the line's taps.
  /// The sinks and the line must outlive the monitor.
  LineMonitor(EventLoop& loop, SerialLine& line, std::size_t line_number, std::string_view protocol,
              std::vector<WireSink*> sinks);
  ~LineMonitor();
  LineMonitor(const LineMonitor&) = delete;
  LineMonitor& operator=(const LineMonitor&) = delete;

  /// Tells of the frames that were under way, as cut short. To be called once, at the end.
  void finish() { cutter_.finish(); }

 private:
  void host_acted(std::span<const std::uint8_t> bytes, const HostSettings& settings);
  void tell(const WirePacket& packet);
  HostInstant instant() const;

  EventLoop& loop_;
  SerialLine& line_;
  std::size_t number_;
  FrameCutter cutter_;
  std::vector<WireSink*> sinks_;
  HostSettings settings_;  // as the sinks know them
};

}  // namespace virtdrive
