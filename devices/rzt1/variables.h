// What stands behind the rows of Appendix A: a setting of the axis, a register with code behind it,
// or something that the axis does.
//
//   Variables variables(servo);
//   variables.write(0, *protocol::find(kTable.parameters, 14), 1500);   // axis 1: KP 1500
//   variables.call(0, 89);                                             // ON
#pragma once

#include <cstddef>
#include <cstdint>

#include "devices/rzt1/codec.h"
#include "firmware_models/rzt1/servo_drive.h"

namespace virtdrive::rzt1 {

constexpr Status status_of(Result result) {
  return static_cast<Status>(result);  // the same codes: 8.2.3
}

struct Reading {
  constexpr Reading(std::int64_t number) : value(number) {}
  constexpr Reading(Status refused) : status(refused) {}
  std::int64_t value = 0;
  Status status = Status::kOk;
};

class Variables {
 public:
  explicit Variables(ServoDrive& servo) : servo_(servo) {}

  /// `axis` is 0 or 1.
  Reading read(std::size_t axis, const ParameterRow& row);
  Status write(std::size_t axis, const ParameterRow& row, std::int64_t value);

  /// True for functions that concern one axis and nothing else; RESET, PLAY, SAVE and RESTORE are
  /// the device's.
  bool has_call(std::uint16_t id) const;
  Status call(std::size_t axis, std::uint16_t id);

 private:
  ServoDrive& servo_;
};

}  // namespace virtdrive::rzt1
