#include "devices/framers.h"

#include <algorithm>
#include <iterator>

#include "core/check.h"
#include "devices/asd7/framer.h"
#include "devices/asd7/table.h"
#include "devices/md485/framer.h"
#include "devices/md485/table.h"
#include "devices/rzt1/framer.h"
#include "devices/rzt1/table.h"
#include "devices/toshiba_mcu/framer.h"
#include "devices/toshiba_mcu/table.h"

namespace virtdrive {
namespace {

struct Entry {
  std::string_view protocol;
  std::unique_ptr<protocol::Framer> (*make)();
};

constexpr Entry kFramers[] = {{toshiba_mcu::kTable.name, toshiba_mcu::make_framer},
                              {md485::kTable.name, md485::make_framer},
                              {rzt1::kTable.name, rzt1::make_framer},
                              {asd7::kTable.name, asd7::make_framer}};

}  // namespace

std::unique_ptr<protocol::Framer> make_framer(std::string_view protocol) {
  const auto* const it = std::ranges::find(kFramers, protocol, &Entry::protocol);
  VIRTDRIVE_CHECK(it != std::end(kFramers), "no framer of protocol '{}'", protocol);
  return it->make();
}

}  // namespace virtdrive
