// Checks a drive against its protocol's table, and measures how fast it answers: one of ours, in
// virtual time or over a port, or the one on the desk.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "devices/host_transport.h"
#include "devices/protocol/walk.h"

namespace virtdrive {

/// From the moment at which a request was handed over to the first byte of its answer.
struct Latencies {
  std::vector<SimDuration> all;  // rising

  /// Of share 0 ... 1; there must be some.
  SimDuration quantile(double share) const;
};

struct DriveCheck {
  protocol::WalkReport walk;
  Latencies latencies;
};

/// `now` is the clock that the transport's patience is counted in.
DriveCheck check_drive(const protocol::Dialect& dialect, HostTransport& transport,
                       const std::function<SimDuration()>& now,
                       const protocol::WalkOptions& options);

/// Sums, latencies, and each failure.
std::string text(const DriveCheck& check);
/// A case for each row of the table.
std::string check_junit(const DriveCheck& check, std::string_view protocol);
/// One object, with every check.
std::string check_json(const DriveCheck& check, std::string_view protocol);

}  // namespace virtdrive
