// A host program's side of a drive, whatever the protocol: commands and parameters by the names
// that the protocol's table gives them.
#pragma once

#include <cstddef>
#include <fmt/format.h>
#include <string>
#include <string_view>

#include "devices/protocol/payload.h"

namespace virtdrive {

struct Reading {
  double value = 0;
  std::string unit;  // "" for none
};

/// Throws SetupError for a name that the protocol has not, and ClientError if the drive refuses or
/// does not answer.
class HostClient {
 public:
  virtual ~HostClient() = default;

  /// Sends a command, e.g. "GetFWVersion", and returns the values of its reply.
  virtual protocol::Values call(std::string_view command, const protocol::Values& request) = 0;
  /// "[CHANNEL.]NAME", e.g. "1.MaxAngAcc". Without a channel: the drive's default one.
  virtual Reading get(std::string_view parameter) = 0;
  /// "[CHANNEL.]NAME=VALUE[UNIT]", e.g. "IqStart=1200mA".
  virtual void set(std::string_view assignment) = 0;
  /// What set() would have to be given behind the "=" to write what the drive has now.
  virtual std::string setting(std::string_view parameter) {
    const Reading now = get(parameter);
    return fmt::format("{}{}", now.value, now.unit);
  }

  virtual void start_motor(std::size_t channel, double rpm) = 0;
  virtual void stop_motor(std::size_t channel) = 0;
};

}  // namespace virtdrive
