// What the sources leave open or contradict each other in, as switches: each can be set on a bench
// ("error_sum=always"), and each begins as the 7-Series is taken to be.
#pragma once

#include <span>
#include <string_view>

#include "core/sim_time.h"
#include "devices/asd7/table.h"

namespace virtdrive::asd7 {

/// How F804's value is read.
enum class TimeOutActions : std::uint8_t { kThree, kMatrix };

struct Profile {
  bool error_sum_always = false;  // else as the request
  bool broadcast_read = false;    // the excerpt allows writes only; VF-S11's manual prints one
  bool ascii_wide = false;        // L in ASCII
  Error mode_error = kModeError;  //
  bool bit14_faulted = false;     // FD01 and FE01, bit 14: ready, or as ETH's example has it
  bool signed_frequency = false;  // FD00, FE00, FD02, FE02
  SimDuration time_out_unit = std::chrono::seconds(1);  // F803
  TimeOutActions time_out_actions = TimeOutActions::kThree;
  SimDuration frame_time_out =
      kSilence;  // of an unfinished frame; S15's 3.5 characters are shorter
  SimDuration reply_time = std::chrono::milliseconds(10);
  SimDuration write_time = std::chrono::milliseconds(50);  // of a reply to a write into the EEPROM
};

struct ProfileSetting {
  std::string_view name;
  std::string_view values;  // "mirror|always", or "milliseconds"
  std::string_view doc;
};

/// All there are, as typed.
std::span<const ProfileSetting> profile_settings();
/// False if there is no such setting; SetupError for a value that it has not.
bool set_profile(Profile& profile, std::string_view name, std::string_view value);

}  // namespace virtdrive::asd7
