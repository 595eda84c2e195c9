#include "pty/serial_line.h"

#include <algorithm>

#include "core/check.h"

namespace virtdrive {
namespace {

void check_settings(const LineSettings& s) {
  VIRTDRIVE_CHECK(
      s.baud > 0 && s.data_bits >= 5 && s.data_bits <= 8 && s.stop_bits >= 1 && s.stop_bits <= 2,
      "a line of {} baud, {} data bits, {} stop bits", s.baud, s.data_bits, s.stop_bits);
}

void check_faults(const LineFaults& f) {
  for (const double probability : {f.lost, f.flipped, f.duplicated, f.delayed}) {
    VIRTDRIVE_CHECK(probability >= 0 && probability <= 1, "a fault with probability {}",
                    probability);
  }
  VIRTDRIVE_CHECK(f.delay >= SimDuration{0}, "a delay of {} ns", f.delay.count());
  VIRTDRIVE_CHECK(f.noise_per_s >= 0 && f.noise_per_s <= 1e6, "{} noise bytes per second",
                  f.noise_per_s);
}

// Who checks parity throws away what fails it; without, a bad stop bit is left to the program.
bool throws_away_errors(const LineSettings& settings) {
  return settings.parity != Parity::kNone;
}

}  // namespace

// --- LineEnd -------------------------------------------------------------------------------------

LineEnd::LineEnd(SerialLine& line, int number, const LineSettings& settings)
    : line_(line),
      settings_(settings),
      talker_(number, line.counters_.to_host_lost),
      listener_([this](const WireByte& byte) { hear(byte); }, &talker_) {}

void LineEnd::attach(SerialReceiver& device) {
  const bool on = attached();
  device_ = &device;
  if (!on) line_.wires(LineDirection::kToDevices).switch_on(listener_, settings_);
}

void LineEnd::detach() {
  if (!attached()) return;
  device_ = nullptr;
  line_.wires(LineDirection::kToDevices).switch_off(listener_);
  line_.wires(LineDirection::kToHost).cut_off(talker_);
}

SimTime LineEnd::send(std::span<const std::uint8_t> bytes) {
  if (!attached()) return line_.loop_.now();
  return line_.wires(LineDirection::kToHost)
      .send(talker_, bytes, settings_, line_.active_faults(LineDirection::kToHost));
}

bool LineEnd::shared() const {
  return line_.devices() > 1;
}

void LineEnd::set_baud(int baud) {
  LineSettings settings = settings_;
  settings.baud = baud;
  set_settings(settings);
}

void LineEnd::set_parity(Parity parity) {
  LineSettings settings = settings_;
  settings.parity = parity;
  set_settings(settings);
}

void LineEnd::set_settings(const LineSettings& settings) {
  check_settings(settings);
  settings_ = settings;
  settings_.timing = line_.settings_.timing;
  line_.wires(LineDirection::kToDevices).tune(listener_, settings_);
  if (number() == 0) line_.set_line(settings_);
}

void LineEnd::hear(const WireByte& byte) {
  if (byte.error && throws_away_errors(settings_)) return;
  ++line_.counters_.to_device;
  device_->receive(byte.byte);
}

// --- SerialLine ----------------------------------------------------------------------------------

SerialLine::SerialLine(EventLoop& loop, const LineSettings& settings, LineOptions options)
    : loop_(loop),
      settings_(settings),
      options_(std::move(options)),
      host_talker_(kHostTalker, counters_.to_device_lost),
      host_ear_([this](const WireByte& byte) { hear_at_host(byte); },
                options_.echo ? nullptr : &host_talker_) {
  check_settings(settings_);
  VIRTDRIVE_CHECK(!options_.echo || options_.duplex == Duplex::kHalf,
                  "an echo on a line of which the host has a pair of its own");
  const std::size_t pairs = options_.duplex == Duplex::kHalf ? 1 : 2;
  for (std::size_t i = 0; i < pairs; ++i) {
    pairs_.push_back(std::make_unique<WirePair>(loop_, options_.chance, counters_));
  }
  wires(LineDirection::kToDevices).add(host_talker_);
  wires(LineDirection::kToHost).add(host_ear_);
  wires(LineDirection::kToHost).switch_on(host_ear_, host_line());
}

SerialLine::~SerialLine() = default;

LineEnd& SerialLine::add_device() {
  return add_device(settings_);
}

LineEnd& SerialLine::add_device(const LineSettings& settings) {
  const int number = static_cast<int>(devices_.size());
  devices_.push_back(std::make_unique<LineEnd>(*this, number, settings_));
  LineEnd& end = *devices_.back();
  wires(LineDirection::kToDevices).add(end.listener_);
  wires(LineDirection::kToHost).add(end.talker_);
  end.set_settings(settings);
  apply_wire_faults();
  return end;
}

void SerialLine::host_send(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return;
  if (host_tap_) host_tap_(bytes, host_, loop_.now());
  wires(LineDirection::kToDevices)
      .send(host_talker_, bytes, host_line(), active_faults(LineDirection::kToDevices));
}

void SerialLine::host_break(SimDuration duration) {
  wires(LineDirection::kToDevices).send_break(host_talker_, duration, host_line());
}

void SerialLine::on_wire(WireTap tap) {
  wire_tap_ = std::move(tap);
  if (taps_.empty()) {
    for (const auto& pair : pairs_) {
      taps_.push_back(std::make_unique<Listener>([this](const WireByte& byte) { wire_tap_(byte); },
                                                 nullptr, Listener::Kind::kTap));
      pair->add(*taps_.back());
    }
  }
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    pairs_[i]->switch_off(*taps_[i]);
    if (wire_tap_) pairs_[i]->switch_on(*taps_[i], settings_);
  }
}

void SerialLine::set_host(const HostSettings& host) {
  if (host == host_) return;
  host_ = host;
  check_settings(host_line());
  wires(LineDirection::kToHost).tune(host_ear_, host_line());
  if (host_tap_) host_tap_({}, host_, loop_.now());
}

void SerialLine::set_faults(LineDirection direction, const LineFaults& faults) {
  check_faults(faults);
  const auto index = static_cast<std::size_t>(direction);
  faults_[index] = faults;
  faulty_[index] =
      faults.lost > 0 || faults.flipped > 0 || faults.duplicated > 0 || faults.delayed > 0;
  apply_wire_faults();
}

const LineFaults* SerialLine::active_faults(LineDirection direction) const {
  const auto index = static_cast<std::size_t>(direction);
  return faulty_[index] ? &faults_[index] : nullptr;
}

// Two directions on one pair: what either asks for.
void SerialLine::apply_wire_faults() {
  const auto& [to_devices, to_host] = faults_;
  wires(LineDirection::kToDevices).cut(host_talker_, to_devices.cut);
  for (const auto& device : devices_) {
    wires(LineDirection::kToHost).cut(device->talker_, to_host.cut);
  }
  if (options_.duplex == Duplex::kHalf) {
    const bool first = to_devices.stuck != LineStuck::kNo;
    pairs_[0]->hold(first ? to_devices.stuck : to_host.stuck);
    pairs_[0]->set_noise(to_devices.noise_per_s + to_host.noise_per_s, settings_);
    return;
  }
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    pairs_[i]->hold(faults_[i].stuck);
    pairs_[i]->set_noise(faults_[i].noise_per_s, settings_);
  }
}

WirePair& SerialLine::wires(LineDirection direction) {
  return options_.duplex == Duplex::kHalf ? *pairs_[0]
                                          : *pairs_[static_cast<std::size_t>(direction)];
}

void SerialLine::set_line(const LineSettings& settings) {
  settings_ = settings;
  wires(LineDirection::kToHost).tune(host_ear_, host_line());
  for (std::size_t i = 0; i < taps_.size(); ++i) pairs_[i]->tune(*taps_[i], settings_);
  apply_wire_faults();
}

void SerialLine::hear_at_host(const WireByte& byte) {
  if (!host_listener_ || (byte.error && throws_away_errors(host_line()))) return;
  ++counters_.to_host;
  host_listener_(byte.byte, loop_.now());
}

LineSettings SerialLine::host_line() const {
  LineSettings line = settings_;
  if (host_.baud != 0) line.baud = host_.baud;
  if (host_.stop_bits != 0) line.stop_bits = host_.stop_bits;
  if (host_.data_bits != 0) line.data_bits = host_.data_bits;
  if (host_.parity) line.parity = *host_.parity;
  return line;
}

}  // namespace virtdrive
