// A host's side of MCU Motor Studio, made from the same tables as the drive.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "devices/host_transport.h"
#include "devices/toshiba_mcu/codec.h"

namespace virtdrive::toshiba_mcu {

struct MotorState {
  std::int32_t actual_rpm;
  std::int32_t target_rpm;
  std::uint32_t current_ma;
  std::uint32_t torque;  // 0.001 Ncm
  std::uint32_t tick_ms;
};

class Client {
 public:
  explicit Client(HostTransport& transport, SimDuration patience = std::chrono::milliseconds(500))
      : transport_(transport), patience_(patience) {}

  /// Sends a request and returns the values of its reply; ClientError otherwise.
  protocol::Values call(std::uint8_t command, const protocol::Values& request);

  void start_motor(std::uint8_t motor_nr) { call(0x00, {motor_nr}); }
  void stop_motor(std::uint8_t motor_nr) { call(0x01, {motor_nr}); }
  MotorState motor_state(std::uint8_t motor_nr);
  /// By the table's name, e.g. "MaxAngAcc".
  UnitValue get(std::uint8_t motor_nr, std::string_view parameter);
  void set(std::uint8_t motor_nr, std::string_view parameter, UnitValue value);
  /// "3.10"
  std::string version();

 private:
  HostTransport& transport_;
  SimDuration patience_;
};

}  // namespace virtdrive::toshiba_mcu
