// A host's side of the 7-Series' protocol, made from the same rows as the drive.
#pragma once

#include <cstdint>
#include <optional>

#include "devices/asd7/codec.h"
#include "devices/host_transport.h"

namespace virtdrive::asd7 {

class Client {
 public:
  /// A reset drive is silent for two seconds, so patience is long.
  explicit Client(HostTransport& transport, Format format = Format::kAscii,
                  SimDuration patience = std::chrono::milliseconds(2500))
      : transport_(transport), format_(format), patience_(patience) {}

  /// Of requests from now on; none: left out, as between two.
  void set_number(std::optional<AsdNumber> number) { number_ = number; }

  /// DriveRefused with the error's code, DriveSilent without an answer, ClientError for a wrong
  /// one.
  std::int64_t read(const ParameterRow& row);
  /// W, which goes into the EEPROM, or P.
  void write(const ParameterRow& row, std::int64_t value, bool keep);
  /// Any command, number and data; the values of its answer, none where none is due.
  protocol::Values call(const CommandRow& row, const protocol::Values& request);

 private:
  Message receive(std::string_view what);

  HostTransport& transport_;
  Format format_;
  SimDuration patience_;
  std::optional<AsdNumber> number_;
};

}  // namespace virtdrive::asd7
