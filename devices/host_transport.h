// How a host-side client reaches a drive: bytes out, bytes in, no more than so long.
//
// The client knows protocol words; whether a real terminal or a simulated line carries them, and
// what clock the patience is counted in, is the transport's business.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>

#include "core/sim_time.h"

namespace virtdrive {

/// The drive answered with an error, or wrongly, or not at all.
class ClientError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// It answered that it will not.
class DriveRefused : public ClientError {
 public:
  DriveRefused(const std::string& what, std::int64_t code) : ClientError(what), code_(code) {}
  std::int64_t code() const { return code_; }

 private:
  std::int64_t code_;
};

/// It did not answer.
class DriveSilent : public ClientError {
 public:
  using ClientError::ClientError;
};

class HostTransport {
 public:
  virtual ~HostTransport() = default;
  virtual void write(std::span<const std::uint8_t> bytes) = 0;
  /// The next byte from the drive; nothing if none comes within `patience`.
  virtual std::optional<std::uint8_t> read(SimDuration patience) = 0;
};

}  // namespace virtdrive
