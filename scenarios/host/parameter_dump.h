// A drive's settings as a host reads them, kept in a file that people can read, compare and write
// back: to an emulated drive, or to the one on the desk.
//
//   virtdrive-dump: 1
//   protocol: toshiba-mcu
//   settings:
//     1.PolePairs: 4
//     1.IqStart: 1200mA
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "devices/protocol/table.h"
#include "scenarios/host_client.h"

namespace virtdrive {

struct ParameterDump {
  std::string protocol;  // a table's name
  /// "[CHANNEL.]NAME" and what HostClient::set() takes behind the "=".
  std::vector<std::pair<std::string, std::string>> settings = {};
  /// What the drive would not tell, and why; comments in the file.
  std::vector<std::string> untold = {};
};

/// Reads every parameter that can be read and written, of each channel ("": the protocol's default
/// one). A drive that does not answer at all is a ClientError.
ParameterDump dump_parameters(HostClient& host, const protocol::ProtocolTable& table,
                              const std::vector<std::string>& channels = {""});

std::string to_yaml(const ParameterDump& dump);
/// SetupError with line and column for a file that is none.
ParameterDump read_dump(const std::string& path);

/// A setting that two dumps do not have in common; nothing: it is not there.
struct SettingDifference {
  std::string name;
  std::optional<std::string> first;
  std::optional<std::string> second;
};
std::vector<SettingDifference> differences(const ParameterDump& first, const ParameterDump& second);

struct Restored {
  std::size_t unchanged = 0;           // had the value already, and were not written
  std::vector<std::string> written;    // "NAME=VALUE"
  std::vector<std::string> unwritten;  // "NAME=VALUE: why"
};
/// Writes what differs, in the file's order, and reads it back.
Restored restore_parameters(HostClient& host, const ParameterDump& dump);

}  // namespace virtdrive
