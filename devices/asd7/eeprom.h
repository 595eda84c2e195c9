// What a drive's parameters are while it runs, and what of them its EEPROM keeps.
//
//   Parameters kept = eeprom.parameters();   // at each start of the CPU
//   eeprom.write(kept);                      // command W
//
// A damaged or unreadable image is replaced by the factory's, and the drive trips on EEP3 or EEP2.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "core/nvm.h"
#include "firmware_models/asd7/ac_drive.h"

namespace virtdrive::asd7 {

/// Every number that a host may write and that outlives a reset.
struct Parameters {
  Settings settings{};
  /// Of the rows that nothing acts upon: AU2, FMSL, FM.
  std::array<std::uint16_t, 3> stored = {0, 0, 100};
};

Parameters factory_parameters(const Model& model);

/// The place of a number in the EEPROM; null for one without.
std::uint16_t* place_of(Parameters& parameters, std::uint16_t number);

/// What can be wrong with it: bench faults.
struct EepromFaults {
  bool write_fails = false;
  bool read_fails = false;
  bool damaged = false;
};

class Eeprom {
 public:
  /// What `memory` holds; the factory's where it holds nothing, or damaged things.
  Eeprom(NonVolatileMemory& memory, const Parameters& factory);

  /// Of the last load() or write().
  const Parameters& parameters() const { return parameters_; }
  const Memory& kept() const { return kept_; }
  const Parameters& factory() const { return factory_; }

  /// Reads the image anew, at power-up. The trip that follows, if it was not good.
  Trip load();
  /// False if it could not be written: the image stays as it was.
  bool write(const Parameters& parameters);
  bool keep(const Memory& kept);

  EepromFaults faults;

 private:
  NonVolatileMemory& memory_;
  Parameters factory_;
  Parameters parameters_;
  Memory kept_;
};

}  // namespace virtdrive::asd7
