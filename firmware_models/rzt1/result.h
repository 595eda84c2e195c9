// How the servo answers a command: the response codes of 8.2.3.
#pragma once

#include <cstdint>

namespace virtdrive::rzt1 {

enum class [[nodiscard]] Result : std::uint8_t {
  kOk = 0,
  kOutOfRange = 4,
  kReadOnly = 5,
  kInterlock = 6,
  kFault = 7,
  kInvalidState = 8,
  kOverflow = 9,
  kExecution = 10,
};

}  // namespace virtdrive::rzt1
