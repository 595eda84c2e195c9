#include "devices/md485/port.h"

#include <fmt/format.h>
#include <utility>

namespace virtdrive::md485 {
namespace {

using namespace std::chrono_literals;
using protocol::Values;

/// A serial line is taken to be free for a broadcast after so long without a byte (assumed).
constexpr SimDuration kFreeLine = 3ms;

std::string text_of(const WireLog& log, const ParameterRow& row, const Values& values) {
  if (!log.has_listener()) return {};
  return fmt::format("{} {}", row.name, describe(protocol::value_fields(row), values));
}

// Identifier and data as they would be printed: most significant byte first.
std::vector<std::uint8_t> bytes_of(const CanFrame& frame) {
  std::vector<std::uint8_t> bytes;
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(frame.id >> shift));
  }
  bytes.insert(bytes.end(), frame.bytes().begin(), frame.bytes().end());
  return bytes;
}

}  // namespace

// --- RS-485 and TTL232 ---------------------------------------------------------------------------

UartPort::UartPort(EventLoop& loop, SerialPort& port, WireLog& log, Taker taker)
    : loop_(loop),
      port_(port),
      log_(log),
      taker_(std::move(taker)),
      silence_(loop.add(Phase::kDevice, [this] {
        for (auto e = decoder_.expire(); e != Decoder::Event::kNone; e = decoder_.expire()) {
          handle(e);
        }
      })) {}

void UartPort::receive(std::uint8_t byte) {
  heard_ = loop_.now();
  for (auto e = decoder_.push(byte); e != Decoder::Event::kNone; e = decoder_.next()) handle(e);
  if (decoder_.idle())
    silence_.cancel();
  else
    silence_.at(loop_.now() + kTable.framing.silence);
}

void UartPort::handle(Decoder::Event event) {
  switch (event) {
    case Decoder::Event::kNone:
    case Decoder::Event::kNoise:
      break;
    case Decoder::Event::kFrame:
      taker_(*this, decoder_.frame(), decoder_.bytes());
      break;
    case Decoder::Event::kUnknownPid:
      log_.tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "unknown PID, no answer");
      break;
    case Decoder::Event::kTooShort:
      log_.tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "too few data, no answer");
      break;
    case Decoder::Event::kBadSum:
      log_.tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), "wrong checksum, no answer");
      break;
  }
}

bool UartPort::is_free() const {
  return decoder_.idle() && loop_.now() - heard_ >= kFreeLine;
}

SimTime UartPort::send(Route route, const ParameterRow& row, const Values& values) {
  const auto bytes = encode_reply(route, row, values);
  log_.tell(WireEvent::Kind::kReply, bytes, text_of(log_, row, values));
  return port_.send(bytes);
}

SimTime UartPort::send_heard(Route route, const CanFrame& frame) {
  const auto bytes = encode_can_resend(route, frame);
  log_.tell(WireEvent::Kind::kReply, bytes, "PID_CAN_RESEND");
  return port_.send(bytes);
}

// --- CAN -----------------------------------------------------------------------------------------

CanBusPort::CanBusPort(EventLoop& loop, CanPort& port, WireLog& log, Taker taker, Tap tap)
    : loop_(loop), port_(port), log_(log), taker_(std::move(taker)), tap_(std::move(tap)) {}

void CanBusPort::receive(const CanFrame& frame) {
  tap_(frame);
  auto request = can_route(protocol::Direction::kRequest, frame);
  if (!request) return;
  switch (read_data(protocol::Direction::kRequest, can_data(frame), *request)) {
    case DataVerdict::kGood:
      taker_(*this, *request, bytes_of(frame));
      break;
    case DataVerdict::kUnknownPid:
      log_.tell(WireEvent::Kind::kBadFrame, bytes_of(frame), "unknown PID, no answer");
      break;
    case DataVerdict::kTooShort:
      log_.tell(WireEvent::Kind::kBadFrame, bytes_of(frame), "too few data, no answer");
      break;
  }
}

SimTime CanBusPort::send(Route route, const ParameterRow& row, const Values& values) {
  const auto frame = can_reply(route, row, values);
  if (frame && port_.send(*frame)) {
    log_.tell(WireEvent::Kind::kReply, bytes_of(*frame), text_of(log_, row, values));
  }
  return loop_.now();
}

}  // namespace virtdrive::md485
