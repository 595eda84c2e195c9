#include "devices/asd7/device.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;

constexpr std::uint16_t kFrequency = 0xFA01;
/// Between two frames of an inter-drive master (assumed).
constexpr SimDuration kMasterPeriod = 100ms;

// F806
enum class InterDrive : std::uint8_t {
  kStop,       // slave: 0 Hz when the master is tripped
  kGoOn,       // slave: goes on
  kEmergency,  // slave: emergency stop
  kCommand,    // master: says its frequency command
  kOutput,     // master: says its output frequency
};

bool is_master(const Settings& s) {
  return s.inter_drive >= static_cast<std::uint16_t>(InterDrive::kCommand);
}

// The line through F811 .. F814. Percent in 0.01 %, frequencies in 0.01 Hz.
double frequency_of(const Settings& s, double percent) {
  const double span = s.point2 - s.point1;
  if (span == 0) return s.point1_frequency;
  const double slope = (s.point2_frequency - s.point1_frequency) / (100 * span);
  return slope * (percent - 100.0 * s.point1) + s.point1_frequency;
}
double percent_of(const Settings& s, double frequency) {
  const double span = s.point2_frequency - s.point1_frequency;
  if (span == 0) return 100.0 * s.point1;
  const double slope = 100.0 * (s.point2 - s.point1) / span;
  return slope * (frequency - s.point1_frequency) + 100.0 * s.point1;
}

std::string describe(const Message& message) {
  std::string text(message.row == nullptr ? "unknown command" : message.row->name);
  if (message.number) {
    const auto digit = [](std::uint8_t d) { return d == AsdNumber::kAny ? '*' : char('0' + d); };
    text = fmt::format("{}{} {}", digit(message.number->tens), digit(message.number->units), text);
  }
  if (message.parameter != nullptr) text += fmt::format(" {}", message.parameter->name);
  if (message.values.size() > 1) text += fmt::format(" {}", message.values[1]);
  return text;
}

std::string describe(Error error) {
  return fmt::format("error {:04X} {}", static_cast<int>(error),
                     kErrors[static_cast<std::size_t>(error)].name);
}

}  // namespace

Device::Device(Station& station)
    : station_(station),
      silence_(station.loop().add(Phase::kDevice,
                                  [this] {
                                    drop("cut short, no answer");
                                    decoder_.reset();
                                  })),
      master_(station.loop().add(Phase::kDevice, [this] { speak_as_master(); })) {
  station_.on_restart([this] { forget(); });
  schedule_master();
}

// What was heard and not finished is gone with the CPU.
void Device::forget() {
  decoder_.reset();
  silence_.cancel();
  schedule_master();
}

// --- Listening -----------------------------------------------------------------------------------

void Device::receive(std::uint8_t byte) {
  if (!station_.hears()) {
    station_.log().tell(WireEvent::Kind::kLost, {&byte, 1}, "the CPU is starting");
    return;
  }
  decoder_.set_ascii_wide(station_.profile().ascii_wide);
  switch (decoder_.push(byte)) {
    case Decoder::Event::kNone:
    case Decoder::Event::kNoise:
      break;
    case Decoder::Event::kMessage:
      take(decoder_.message());
      break;
    case Decoder::Event::kFormatError:
      drop("no message, no answer");
      break;
    case Decoder::Event::kUnknownCommand:
      drop("unknown command, no answer");
      break;
  }
  if (decoder_.idle())
    silence_.cancel();
  else
    silence_.at(station_.loop().now() + station_.profile().frame_time_out);
}

void Device::drop(std::string_view why) {
  station_.log().tell(WireEvent::Kind::kBadFrame, decoder_.bytes(), why);
}

bool Device::is_for_me(const Message& message) const {
  return !message.number || message.number->matches(station_.settings().number);
}

// Of a broadcast the drive answers whose number has zeros for the stars; it may only write
// (excerpt, p. 25).
bool Device::answers(const Message& message) const {
  if (message.row != nullptr && !message.row->replies) return false;
  if (!message.number || !message.number->is_broadcast()) return true;
  const bool reads = message.row != nullptr && !writes(*message.row);
  if (reads && !station_.profile().broadcast_read) return false;
  const AsdNumber one = message.number->representative();
  return 10 * one.tens + one.units == station_.settings().number;
}

void Device::take(const Message& message) {
  if (!is_for_me(message)) return;
  if (station_.busy()) {
    station_.log().tell(WireEvent::Kind::kLost, decoder_.bytes(),
                        "the answer to the one before is still to come");
    return;
  }
  if (message.error == Error::kSum) {
    drop("wrong checksum");
    return refuse(message, Error::kSum);
  }
  station_.log().tell(WireEvent::Kind::kRequest, decoder_.bytes(),
                      station_.log().has_listener() ? describe(message) : std::string());
  if (message.error)
    refuse(message, *message.error);
  else
    act(message);
  station_.accepted();
}

void Device::act(const Message& message) {
  if (!message.row->replies) return act_on_master(message);
  const auto number = static_cast<std::uint16_t>(message.values[0]);
  Registers::Answer answer;
  if (writes(*message.row)) {
    station_.log().note_use(message.parameter->name, message.parameter->support);
    const ReplyStyle before = style();
    const Message request = message;  // a reset forgets the decoder's
    const bool answering = answers(message);
    const Keep keep = message.row->code == 'W' ? Keep::kEeprom : Keep::kRam;
    answer = station_.registers().write(number, message.values[1], keep);
    if (answer.silent || !answering) return;
    if (answer.error) return refuse(request, *answer.error);
    station_.answer(encode_reply(request, answer.value, before), "done", answer.stored);
    return;
  }
  if (!answers(message)) return;
  answer = station_.registers().read(number);
  if (answer.error) return refuse(message, *answer.error);
  station_.answer(encode_reply(message, answer.value, style()), fmt::format("{}", answer.value),
                  false);
}

void Device::refuse(const Message& message, Error error) {
  if (!answers(message)) return;
  station_.answer(encode_error(message, error, style()), describe(error), false);
}

ReplyStyle Device::style() const {
  return {.tripped = station_.drive().tripped(),
          .error_sum_always = station_.profile().error_sum_always,
          .mode_error = station_.profile().mode_error};
}

// --- Inter-drive communication (VF-S15) ----------------------------------------------------------

void Device::act_on_master(const Message& message) {
  const Settings& s = station_.settings();
  if (is_master(s) || message.values[0] != kFrequency) return;
  if (message.row->code == 'S') {
    const auto percent = static_cast<double>(message.values[1]);
    if (percent > 10'000) return;
    const double highest = s.maximum_frequency;
    const double frequency = std::clamp(frequency_of(s, percent), 0.0, highest);
    station_.drive().set_frequency(static_cast<std::uint16_t>(std::lround(frequency)));
    return;
  }
  switch (static_cast<InterDrive>(s.inter_drive)) {
    case InterDrive::kStop:
      station_.drive().set_frequency(0);
      break;
    case InterDrive::kEmergency:
      station_.drive().set_command(station_.drive().command() | kCommandEmergency);
      break;
    default:
      break;
  }
}

void Device::schedule_master() {
  master_.at(station_.loop().now() + kMasterPeriod);
}

void Device::speak_as_master() {
  schedule_master();
  const Settings& s = station_.settings();
  if (!is_master(s) || !station_.hears() || station_.busy()) return;
  const Monitor monitor = station_.drive().monitor();
  const bool output = s.inter_drive == static_cast<std::uint16_t>(InterDrive::kOutput);
  const double frequency = output ? monitor.output_frequency : monitor.frequency_command;
  const double percent = std::clamp(percent_of(s, frequency), 0.0, 10'000.0);
  const std::uint8_t code = station_.drive().tripped() ? 's' : 'S';
  const Message message{.format = Format::kBinary16,
                        .row = protocol::find(kTable.commands, code),
                        .parameter = protocol::find(kTable.parameters, kFrequency),
                        .values = {kFrequency, std::lround(percent)}};
  station_.say(encode_request(message), "to the other drives");
}

}  // namespace virtdrive::asd7
