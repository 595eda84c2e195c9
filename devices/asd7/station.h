// What a drive does on its line whatever protocol is spoken there: it answers after its time, runs
// the time-out's clock, takes its line settings at a start, and keeps what its EEPROM keeps.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/event_loop.h"
#include "devices/asd7/registers.h"
#include "devices/serial_port.h"
#include "devices/wire_log.h"

namespace virtdrive::asd7 {

class Station {
 public:
  Station(EventLoop& loop, SerialPort& port, AcDrive& drive, Eeprom& eeprom, const Profile& profile,
          WireListener listener, NoteListener notes);
  Station(const Station&) = delete;
  Station& operator=(const Station&) = delete;

  /// The CPU runs: otherwise it hears nothing.
  bool hears() const { return drive_.alive(); }
  /// Called when the CPU starts and when it dies: what was under way is gone.
  void on_restart(std::function<void()> restarted) { restarted_ = std::move(restarted); }

  EventLoop& loop() { return loop_; }
  AcDrive& drive() { return drive_; }
  Registers& registers() { return registers_; }
  WireLog& log() { return log_; }
  const WireCounters& counters() const { return log_.counters(); }
  const Profile& profile() const { return registers_.profile(); }
  const Settings& settings() const { return registers_.settings(); }

  /// A frame for this drive was taken and acted upon: the time-out (F803) counts from here.
  void accepted();
  /// An answer is still to come.
  bool busy() const { return answer_.due() != kNever; }
  /// Leaves after the time that the drive takes, and not before F805.
  void answer(std::vector<std::uint8_t> bytes, std::string text, bool stored);
  /// At once, unasked.
  void say(std::span<const std::uint8_t> bytes, std::string_view text);

  /// What `characters` take on the line as it is set.
  SimDuration time_of(double characters) const;
  /// F800 and F801 count from now on.
  void take_line_settings();

 private:
  void started();
  void stopped();
  void timed_out();
  void keep_memory();

  EventLoop& loop_;
  SerialPort& port_;
  AcDrive& drive_;
  Eeprom& eeprom_;
  Registers registers_;
  WireLog log_;
  std::function<void()> restarted_;

  std::uint16_t baud_code_, parity_code_;  // that the line is set to
  bool lost_ = false;                      // the host is
  std::vector<std::uint8_t> bytes_;        // of the answer to come
  std::string text_;
  Wakeup answer_;
  Wakeup time_out_;
  Wakeup housekeeping_;
};

/// bit/s of a value of F800.
int baud_of(std::uint16_t code);

}  // namespace virtdrive::asd7
