#include "scenarios/drive.h"

#include <algorithm>
#include <utility>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/drives/asd7.h"
#include "scenarios/drives/md.h"
#include "scenarios/drives/rzt1.h"
#include "scenarios/drives/toshiba_mcu.h"

namespace virtdrive {

const std::vector<DriveKind>& drive_catalogue() {
  static const std::vector<DriveKind> catalogue = [] {
    std::vector<DriveKind> kinds = {toshiba_mcu_kind()};
    for (DriveKind& kind : md_kinds()) kinds.push_back(std::move(kind));
    for (DriveKind& kind : asd7_kinds()) kinds.push_back(std::move(kind));
    kinds.push_back(rzt1_kind());
    return kinds;
  }();
  return catalogue;
}

const DriveKind& find_drive(std::string_view name) {
  const auto it = std::ranges::find(drive_catalogue(), name, &DriveKind::name);
  if (it != drive_catalogue().end()) return *it;
  std::vector<std::string_view> names;
  for (const DriveKind& kind : drive_catalogue()) names.push_back(kind.name);
  throw SetupError(unknown_name("drive", name, names) +
                   " ('virtdrive list drives' shows them all)");
}

const DriveKind& find_protocol(std::string_view name) {
  const auto speaks = [&](const DriveKind& kind) { return kind.table.name == name; };
  const auto& kinds = drive_catalogue();
  if (std::ranges::find(kinds, name, &DriveKind::name) != kinds.end()) return find_drive(name);
  const auto it = std::ranges::find_if(kinds, speaks);
  return it != kinds.end() ? *it : find_drive(name);
}

}  // namespace virtdrive
