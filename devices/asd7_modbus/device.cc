#include "devices/asd7_modbus/device.h"

#include <fmt/format.h>

namespace virtdrive::asd7_modbus {
namespace {

using asd7::Error;
using asd7::Keep;
using asd7::Registers;

// The error of the register bank as Modbus says it.
Exception exception_of(Error error) {
  switch (error) {
    case Error::kNumber:
      return Exception::kAddress;
    case Error::kRange:
      return Exception::kValue;
    default:
      return Exception::kFailure;
  }
}

// A word is unsigned on the wire; a signed register's is its two's complement.
std::int64_t from_word(std::uint16_t number, std::int64_t word) {
  const ParameterRow* row = protocol::find(kTable.parameters, number);
  const bool sign = row != nullptr && protocol::is_signed(row->type);
  return sign && word >= 0x8000 ? word - 0x10000 : word;
}

std::string describe(const Frame& frame) {
  if (frame.row == nullptr) return fmt::format("function {:02x}", frame.function);
  const std::string values =
      frame.values ? protocol::describe(frame.row->request, *frame.values) : "";
  return fmt::format("{} {}", frame.row->name, values);
}

}  // namespace

Device::Device(asd7::Station& station)
    : station_(station), silence_(station.loop().add(Phase::kDevice, [this] { frame_ended(); })) {
  station_.on_restart([this] { forget(); });
}

void Device::forget() {
  buffer_.clear();
  too_long_ = false;
  silence_.cancel();
}

void Device::receive(std::uint8_t byte) {
  if (!station_.hears()) {
    station_.log().tell(WireEvent::Kind::kLost, {&byte, 1}, "the CPU is starting");
    return;
  }
  too_long_ = too_long_ || buffer_.full();
  if (!too_long_) buffer_.push(byte);
  silence_.at(station_.loop().now() + station_.time_of(kSilentCharacters));
}

void Device::frame_ended() {
  const auto drop = [&](std::string_view why) {
    station_.log().tell(WireEvent::Kind::kBadFrame, buffer_.bytes(), why);
  };
  Frame frame;
  const FrameError error = decode(protocol::Direction::kRequest, buffer_.bytes(), frame);
  if (too_long_ || error != FrameError::kNone) {
    drop(too_long_                   ? "too long, no answer"
         : error == FrameError::kCrc ? "wrong CRC, no answer"
                                     : "too short, no answer");
  } else if (frame.unit == kAllDrives || frame.unit == station_.settings().number) {
    if (station_.busy()) {
      station_.log().tell(WireEvent::Kind::kLost, buffer_.bytes(),
                          "the answer to the one before is still to come");
    } else {
      station_.log().tell(WireEvent::Kind::kRequest, buffer_.bytes(),
                          station_.log().has_listener() ? describe(frame) : std::string());
      act(frame);
      station_.accepted();
    }
  }
  buffer_.clear();
  too_long_ = false;
}

void Device::act(const Frame& frame) {
  if (frame.row == nullptr) return refuse(frame, Exception::kFunction);
  if (!frame.values) return refuse(frame, Exception::kValue);
  const protocol::Values& values = *frame.values;
  const auto number = static_cast<std::uint16_t>(values[0]);
  switch (frame.row->code) {
    case kRead: {
      if (frame.unit == kAllDrives) return;
      if (values[1] != 1) return refuse(frame, Exception::kValue);
      const Registers::Answer answer = station_.registers().read(number);
      if (answer.error) return refuse(frame, exception_of(*answer.error));
      station_.answer(encode_reply(frame.unit, *frame.row, {2, answer.value}),
                      fmt::format("{}", answer.value), false);
      return;
    }
    case kWrite:
      return write(frame, number, values[1]);
    default:
      if (values[1] != 1 || values[2] != 2) return refuse(frame, Exception::kValue);
      return write(frame, number, values[3]);
  }
}

void Device::write(const Frame& frame, std::uint16_t number, std::int64_t word) {
  if (const ParameterRow* row = protocol::find(kTable.parameters, number)) {
    station_.log().note_use(row->name, row->support);
  }
  const std::uint8_t unit = frame.unit;
  const Registers::Answer answer =
      station_.registers().write(number, from_word(number, word), Keep::kEeprom);
  if (answer.silent || unit == kAllDrives) return;
  if (answer.error) return refuse(frame, exception_of(*answer.error));
  station_.answer(encode_reply(unit, *frame.row, {number, frame.row->code == kWrite ? word : 1}),
                  "done", answer.stored);
}

void Device::refuse(const Frame& frame, Exception exception) {
  if (frame.unit == kAllDrives) return;
  station_.answer(
      encode_exception(frame.unit, frame.function, exception),
      fmt::format("exception {}", kExceptions[static_cast<std::size_t>(exception) - 1].name),
      false);
}

}  // namespace virtdrive::asd7_modbus
