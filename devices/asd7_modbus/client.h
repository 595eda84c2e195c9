// A Modbus RTU host, one register at a time.
#pragma once

#include <cstdint>

#include "devices/asd7_modbus/codec.h"
#include "devices/host_transport.h"

namespace virtdrive::asd7_modbus {

class Client {
 public:
  explicit Client(HostTransport& transport, std::uint8_t unit = kFactoryUnit,
                  SimDuration patience = std::chrono::milliseconds(2500))
      : transport_(transport), unit_(unit), patience_(patience) {}

  void set_unit(std::uint8_t unit) { unit_ = unit; }

  /// DriveRefused with the exception's code, DriveSilent without an answer, ClientError for a wrong
  /// one. Signed registers come as signed numbers.
  std::int64_t read(const ParameterRow& row);
  void write(const ParameterRow& row, std::int64_t value);
  /// A function with its values; those of its answer, none to a broadcast.
  protocol::Values call(const CommandRow& row, const protocol::Values& request);

 private:
  HostTransport& transport_;
  std::uint8_t unit_;
  SimDuration patience_;
};

}  // namespace virtdrive::asd7_modbus
