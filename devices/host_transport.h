// How a host-side client reaches a drive: bytes out, bytes in, no more than so long.
//
// The client knows protocol words; whether a real terminal or a simulated line carries them, and
// what clock the patience is counted in, is the transport's business.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stdexcept>

#include "core/sim_time.h"

namespace virtdrive {

/// The drive answered with an error, or wrongly, or not at all.
class ClientError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class HostTransport {
 public:
  virtual ~HostTransport() = default;
  virtual void write(std::span<const std::uint8_t> bytes) = 0;
  /// The next byte from the drive; nothing if none comes within `patience`.
  virtual std::optional<std::uint8_t> read(SimDuration patience) = 0;
};

}  // namespace virtdrive
