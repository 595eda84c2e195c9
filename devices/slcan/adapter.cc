#include "devices/slcan/adapter.h"

#include <chrono>
#include <fmt/format.h>
#include <string>
#include <vector>

namespace virtdrive::slcan {
namespace {

// What a CANUSB with this firmware says; the serial number is nobody's.
constexpr std::string_view kVersion = "V1013";
constexpr std::string_view kSerialNumber = "NV001";
constexpr std::int64_t kStampPeriodMs = 60'000;

}  // namespace

void Adapter::receive(std::uint8_t byte) {
  switch (decoder_.push(byte)) {
    case Decoder::Event::kNone:
      return;
    case Decoder::Event::kTooLong:
      return answer("", kError);
    case Decoder::Event::kLine:
      break;
  }
  const auto line = parse(decoder_.line());
  if (!line || !takes(line->command->when)) return answer("", kError);
  act(*line);
}

bool Adapter::takes(When when) const {
  switch (when) {
    case When::kAlways:
      return true;
    case When::kClosed:
      return !open_;
    case When::kOpen:
      return open_;
    case When::kSending:
      return open_ && !listens_only_;
  }
  return false;
}

void Adapter::act(const Line& line) {
  switch (line.command->letter) {
    case 'S':
      if (line.number >= kBitRates.size()) return answer("", kError);
      bit_rate_ = kBitRates[line.number];
      return answer("");
    case 's':
      bit_rate_ = bit_rate_of(line.number);
      return answer("");
    case 'O':
    case 'L':
      return open(line.command->letter == 'L');
    case 'C':
      can_.close();
      open_ = false;
      return answer("");
    case 't':
    case 'T':
    case 'r':
    case 'R':
      return transmit(line.frame);
    case 'F':
      return answer(fmt::format("F{:02X}", flags()));
    case 'M':
      filter_.code = line.number;
      return answer("");
    case 'm':
      filter_.mask = line.number;
      return answer("");
    case 'V':
      return answer(kVersion);
    case 'N':
      return answer(kSerialNumber);
    case 'Z':
      stamps_ = line.number != 0;
      return answer("", line.number <= 1 ? kOk : kError);
    default:
      return answer("", kError);
  }
}

void Adapter::open(bool listen_only) {
  if (bit_rate_ == 0) return answer("", kError);
  can_.open(bit_rate_, listen_only);
  open_ = true;
  listens_only_ = listen_only;
  answer("");
}

void Adapter::transmit(const CanFrame& frame) {
  if (!can_.send(frame)) return answer("", kError);
  answer(frame.extended ? "Z" : "z");
}

void Adapter::receive(const CanFrame& frame) {
  if (!open_ || !filter_.passes(frame)) return;
  std::string text = text_of(frame);
  if (stamps_) {
    const auto ms = std::chrono::floor<std::chrono::milliseconds>(loop_.now().time_since_epoch());
    text += fmt::format("{:04X}", ms.count() % kStampPeriodMs);
  }
  answer(text);
}

std::uint8_t Adapter::flags() const {
  const CanState state = can_.state();
  return static_cast<std::uint8_t>((state.warning() ? kErrorWarning : 0) |
                                   (state.passive() ? kErrorPassive : 0) |
                                   (state.bus_off ? kBusError : 0));
}

void Adapter::answer(std::string_view text, std::uint8_t end) {
  std::vector<std::uint8_t> bytes(text.begin(), text.end());
  bytes.push_back(end);
  port_.send(bytes);
}

}  // namespace virtdrive::slcan
