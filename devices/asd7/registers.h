// The register bank: every communication number joined to the drive, whatever protocol asks.
//
//   registers.write(0xFA01, 6000, Keep::kRam);   // 60.00 Hz
//   registers.read(0xFD00).value;
#pragma once

#include <cstdint>
#include <optional>

#include "core/event_loop.h"
#include "devices/asd7/eeprom.h"
#include "devices/asd7/profile.h"
#include "devices/asd7/table.h"

namespace virtdrive::asd7 {

/// Where a write goes.
enum class Keep : std::uint8_t { kRam, kEeprom };

class Registers {
 public:
  struct Answer {
    std::optional<Error> error = {};
    std::int64_t value = 0;
    bool silent = false;  // done, or not: nobody says so (a reset by FA00)
    bool stored = false;  // went into the EEPROM
  };

  Registers(const EventLoop& loop, AcDrive& drive, Eeprom& eeprom, const Profile& profile);

  Answer read(std::uint16_t number) const;
  Answer write(std::uint16_t number, std::int64_t value, Keep keep);
  /// Whether write() would be refused, and why.
  std::optional<Error> check(const ParameterRow& row, std::int64_t value) const;
  /// What a row takes now: the table's range, or less where another setting limits it.
  Range range(const ParameterRow& row) const;

  /// What the EEPROM holds becomes what the drive runs with: at a start of the CPU.
  void restore();
  const Settings& settings() const { return ram_.settings; }
  /// False where F804 asks for nothing to be done.
  bool minds_time_out() const;
  const Profile& profile() const { return profile_; }
  const AcDrive& drive() const { return drive_; }

 private:
  std::int64_t status(std::uint16_t bits) const;
  std::int64_t monitor_value(std::uint16_t number) const;
  Answer write_parameter(const ParameterRow& row, std::int64_t value, Keep keep);
  Answer write_volatile(const ParameterRow& row, std::int64_t value);
  Answer initialise(std::int64_t how);
  void hand_over();
  bool initialising() const { return loop_.now() < initialised_; }

  const EventLoop& loop_;
  AcDrive& drive_;
  Eeprom& eeprom_;
  const Profile& profile_;
  Parameters ram_;
  SimTime initialised_ = kSimStart;  // when tYP is done
};

}  // namespace virtdrive::asd7
