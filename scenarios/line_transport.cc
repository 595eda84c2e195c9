#include "scenarios/line_transport.h"

#include <utility>

namespace virtdrive {

LineTransport::LineTransport(EventLoop& loop, SerialLine& line) : loop_(loop), line_(line) {
  before_ = line_.on_host_byte([this](std::uint8_t byte, SimTime) { heard_.push_back(byte); });
}

LineTransport::~LineTransport() {
  line_.on_host_byte(std::move(before_));
}

void LineTransport::write(std::span<const std::uint8_t> bytes) {
  line_.host_send(bytes);
}

std::optional<std::uint8_t> LineTransport::read(SimDuration patience) {
  if (!loop_.run_until(loop_.now() + patience, [this] { return !heard_.empty(); })) {
    return std::nullopt;
  }
  const std::uint8_t byte = heard_.front();
  heard_.pop_front();
  return byte;
}

}  // namespace virtdrive
