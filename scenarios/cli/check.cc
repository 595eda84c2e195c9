#include "core/check.h"

#include <fmt/format.h>

#include "pty/host_port.h"
#include "scenarios/bench.h"
#include "scenarios/cli/commands.h"
#include "scenarios/host/drive_check.h"
#include "scenarios/line_transport.h"
#include "scenarios/output_file.h"

namespace virtdrive {
namespace {

using protocol::Allow;

protocol::WalkOptions walk_options(const CheckOptions& options, const DriveKind& kind) {
  return {
      .channel = options.channel.value_or(kind.checked_channel),
      .allow = options.allow,
      .at_factory = options.factory,
      .patience = options.patience_s ? from_seconds(*options.patience_s) : kind.checked_patience,
      .silence = from_seconds(options.silence_s),
      .most_failures = options.most_failures};
}

DriveCheck check_at_port(const CheckOptions& options, const DriveKind& kind) {
  HostPort port(options.port, TtySettings{.baud = options.baud.value_or(kind.ports.front().baud),
                                          .parity = options.parity});
  return check_drive(
      *kind.make_dialect(), port, [&] { return port.since_open(); }, walk_options(options, kind));
}

// In virtual time, where nothing disturbs.
DriveCheck check_inside(const CheckOptions& options, const DriveKind& kind) {
  constexpr SimDuration kStart = std::chrono::seconds(3);  // any of ours has started by then
  Bench bench({.drives = {{.kind = std::string(kind.name)}}});
  bench.run_for(kStart);
  LineTransport transport(bench.loop(), bench.line());
  return check_drive(
      *kind.make_dialect(), transport, [&] { return bench.loop().now() - kSimStart; },
      walk_options(options, kind));
}

void write(const std::string& option, const std::string& path, const std::string& content) {
  if (path.empty()) return;
  OutputFile file(option, path);
  file.write(content);
  file.close();
}

}  // namespace

int check(const CheckOptions& options) {
  if (options.port.empty() == options.drive.empty()) {
    throw SetupError("check drive: expected either --port PORT or --drive DRIVE");
  }
  if (!options.port.empty() && options.protocol.empty()) {
    throw SetupError("check drive --port: --protocol is missing");
  }
  const DriveKind& kind =
      options.port.empty() ? find_drive(options.drive) : find_protocol(options.protocol);
  if (!kind.make_dialect) {
    throw SetupError(fmt::format("check drive: there are no checks for {}", kind.table.name));
  }
  const DriveCheck checked =
      options.port.empty() ? check_inside(options, kind) : check_at_port(options, kind);
  fmt::print("{}", text(checked));
  write("--junit", options.junit, check_junit(checked, kind.table.name));
  write("--json", options.json, check_json(checked, kind.table.name));
  return checked.walk.failures() == 0 ? kExitOk : kExitFailed;
}

}  // namespace virtdrive
