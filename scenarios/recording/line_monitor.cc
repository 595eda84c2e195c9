#include "scenarios/recording/line_monitor.h"

#include <utility>

namespace virtdrive {

using protocol::Direction;

LineMonitor::LineMonitor(EventLoop& loop, SerialLine& line, std::size_t line_number,
                         std::string_view protocol, std::vector<WireSink*> sinks)
    : loop_(loop),
      line_(line),
      number_(line_number),
      cutter_(protocol, [this](const WirePacket& packet) { tell(packet); }),
      sinks_(std::move(sinks)) {
  host_acted({}, line.host());
  line_.on_host_send(
      [this](auto bytes, const HostSettings& settings, SimTime) { host_acted(bytes, settings); });
  line_.on_wire([this](const WireByte& byte) {
    cutter_.hear(byte.talker == kHostTalker ? Direction::kRequest : Direction::kReply, byte);
  });
}

LineMonitor::~LineMonitor() {
  line_.on_host_send(nullptr);
  line_.on_wire(nullptr);
}

HostInstant LineMonitor::instant() const {
  return {.time = loop_.now(), .before_events = loop_.next() <= loop_.now()};
}

void LineMonitor::host_acted(std::span<const std::uint8_t> bytes, const HostSettings& settings) {
  if (settings != settings_) {
    settings_ = settings;
    for (WireSink* const sink : sinks_) sink->host_settings(number_, instant(), settings);
  }
  if (bytes.empty()) return;
  for (WireSink* const sink : sinks_) sink->host_write(number_, instant(), bytes);
}

void LineMonitor::tell(const WirePacket& packet) {
  for (WireSink* const sink : sinks_) sink->packet(number_, packet);
}

}  // namespace virtdrive
