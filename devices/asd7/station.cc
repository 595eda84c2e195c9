#include "devices/asd7/station.h"

#include <algorithm>
#include <array>
#include <utility>

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;

constexpr std::array<int, 4> kBauds = {1200, 2400, 4800, 9600};  // F800
constexpr SimDuration kWaitUnit = 10ms;                          // F805
/// Trips and hours go into the EEPROM within that.
constexpr SimDuration kHousekeeping = 1s;
constexpr std::uint64_t kHourSeconds = 3600;

}  // namespace

int baud_of(std::uint16_t code) {
  return kBauds[std::min<std::size_t>(code, kBauds.size() - 1)];
}

Station::Station(EventLoop& loop, SerialPort& port, AcDrive& drive, Eeprom& eeprom,
                 const Profile& profile, WireListener listener, NoteListener notes)
    : loop_(loop),
      port_(port),
      drive_(drive),
      eeprom_(eeprom),
      registers_(loop, drive, eeprom, profile),
      log_(loop, std::move(listener), std::move(notes)),
      baud_code_(eeprom.factory().settings.baud),
      parity_code_(eeprom.factory().settings.parity),
      answer_(loop.add(Phase::kDevice, [this] { say(bytes_, text_); })),
      time_out_(loop.add(Phase::kDevice, [this] { timed_out(); })),
      housekeeping_(loop.add(Phase::kDevice, [this] { keep_memory(); })) {
  drive_.set_on_start([this] { started(); });
  drive_.set_on_stop([this] { stopped(); });
  take_line_settings();
  housekeeping_.at(loop_.now() + kHousekeeping);
}

// --- Life ----------------------------------------------------------------------------------------

void Station::started() {
  const Trip trip = eeprom_.load();
  registers_.restore();
  take_line_settings();
  if (trip != Trip::kNone) drive_.eeprom_failed(trip);
  if (restarted_) restarted_();
}

void Station::stopped() {
  keep_memory();
  answer_.cancel();
  time_out_.cancel();
  lost_ = false;
  if (restarted_) restarted_();
}

void Station::take_line_settings() {
  const Settings& s = settings();
  if (s.baud != baud_code_) port_.set_baud(baud_of(s.baud));
  if (s.parity != parity_code_) port_.set_parity(static_cast<Parity>(s.parity));
  baud_code_ = s.baud;
  parity_code_ = s.parity;
}

SimDuration Station::time_of(double characters) const {
  const int bits = parity_code_ == 0 ? 10 : 11;
  return from_seconds(characters * bits / baud_of(baud_code_));
}

// At a trip at once, else once in an hour of running and when the CPU dies.
void Station::keep_memory() {
  housekeeping_.at(loop_.now() + kHousekeeping);
  const Memory& now = drive_.memory();
  const Memory& kept = eeprom_.kept();
  const bool due = now.past_trips != kept.past_trips || now.kept_trip != kept.kept_trip ||
                   now.eeprom_writes != kept.eeprom_writes ||
                   now.run_seconds >= kept.run_seconds + kHourSeconds ||
                   (!drive_.alive() && now != kept);
  if (due) eeprom_.keep(now);
}

// --- Time-out ------------------------------------------------------------------------------------

void Station::accepted() {
  if (!hears()) return;  // it was a reset
  if (std::exchange(lost_, false)) drive_.communication_found();
  const std::uint16_t time_out = settings().time_out;
  if (time_out == 0)
    time_out_.cancel();
  else
    time_out_.at(loop_.now() + time_out * profile().time_out_unit);
}

void Station::timed_out() {
  if (!registers_.minds_time_out()) return;
  lost_ = true;
  drive_.communication_lost();
}

// --- Talking -------------------------------------------------------------------------------------

void Station::answer(std::vector<std::uint8_t> bytes, std::string text, bool stored) {
  bytes_ = std::move(bytes);
  text_ = std::move(text);
  const SimDuration takes = stored ? profile().write_time : profile().reply_time;
  answer_.at(loop_.now() + std::max(takes, settings().wait_time * kWaitUnit));
}

void Station::say(std::span<const std::uint8_t> bytes, std::string_view text) {
  log_.tell(WireEvent::Kind::kReply, bytes, text);
  port_.send(bytes);
}

}  // namespace virtdrive::asd7
