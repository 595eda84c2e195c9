#include "scenarios/host/parameter_dump.h"

#include <algorithm>
#include <fmt/format.h>

#include "core/check.h"
#include "core/yaml_reader.h"
#include "devices/host_transport.h"

namespace virtdrive {
namespace {

constexpr std::string_view kVersionKey = "virtdrive-dump";

bool is_setting(const protocol::ParameterRow& row) {
  return row.access == protocol::Access::kReadWrite &&
         row.support != protocol::Support::kRejected && row.type != protocol::WireType::kText;
}

const std::string* find(const ParameterDump& dump, std::string_view name) {
  const auto it = std::ranges::find(dump.settings, name, [](const auto& s) { return s.first; });
  return it == dump.settings.end() ? nullptr : &it->second;
}

std::optional<std::string> copy_of(const std::string* text) {
  return text == nullptr ? std::nullopt : std::optional(*text);
}

}  // namespace

ParameterDump dump_parameters(HostClient& host, const protocol::ProtocolTable& table,
                              const std::vector<std::string>& channels) {
  ParameterDump dump{.protocol = std::string(table.name)};
  bool spoke = false;
  for (const std::string& channel : channels) {
    for (const protocol::ParameterRow& row : table.parameters) {
      if (!is_setting(row)) continue;
      const std::string name =
          channel.empty() ? std::string(row.name) : fmt::format("{}.{}", channel, row.name);
      try {
        dump.settings.emplace_back(name, host.setting(name));
        spoke = true;
      } catch (const DriveSilent& silence) {
        if (!spoke) throw;
        dump.untold.push_back(fmt::format("{}: {}", name, silence.what()));
      } catch (const ClientError& error) {
        spoke = true;
        dump.untold.push_back(fmt::format("{}: {}", name, error.what()));
      }
    }
  }
  return dump;
}

std::string to_yaml(const ParameterDump& dump) {
  std::string text = fmt::format("{}: 1\nprotocol: {}\nsettings:\n", kVersionKey, dump.protocol);
  for (const auto& [name, value] : dump.settings) text += fmt::format("  {}: {}\n", name, value);
  for (const std::string& what : dump.untold) text += fmt::format("  # {}\n", what);
  return text;
}

ParameterDump read_dump(const std::string& path) {
  const YamlFile file = YamlFile::read(path);
  const YamlMap root = file.root().map({kVersionKey, "protocol", "settings"});
  if (root[kVersionKey].integer() != 1) root[kVersionKey].fail("expected 1, the version known");
  ParameterDump dump{.protocol = root["protocol"].text()};
  const YamlMap settings = root["settings"].map();
  for (const std::string_view name : settings.keys()) {
    dump.settings.emplace_back(name, settings[name].text());
  }
  return dump;
}

std::vector<SettingDifference> differences(const ParameterDump& first,
                                           const ParameterDump& second) {
  std::vector<SettingDifference> found;
  for (const auto& [name, value] : first.settings) {
    const std::string* const other = find(second, name);
    if (other == nullptr || *other != value) found.push_back({name, value, copy_of(other)});
  }
  for (const auto& [name, value] : second.settings) {
    if (find(first, name) == nullptr) found.push_back({name, std::nullopt, value});
  }
  return found;
}

Restored restore_parameters(HostClient& host, const ParameterDump& dump) {
  Restored restored;
  for (const auto& [name, value] : dump.settings) {
    const std::string assignment = fmt::format("{}={}", name, value);
    try {
      if (host.setting(name) == value) {
        ++restored.unchanged;
        continue;
      }
      host.set(assignment);
      const std::string now = host.setting(name);
      if (now == value)
        restored.written.push_back(assignment);
      else
        restored.unwritten.push_back(fmt::format("{}: the drive has {} now", assignment, now));
    } catch (const ClientError& error) {
      restored.unwritten.push_back(fmt::format("{}: {}", assignment, error.what()));
    }
  }
  return restored;
}

}  // namespace virtdrive
