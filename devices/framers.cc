#include "devices/framers.h"

#include <algorithm>
#include <iterator>

#include "core/check.h"
#include "devices/asd7/framer.h"
#include "devices/asd7/table.h"
#include "devices/asd7_modbus/framer.h"
#include "devices/asd7_modbus/table.h"
#include "devices/md485/framer.h"
#include "devices/md485/table.h"
#include "devices/rzt1/framer.h"
#include "devices/rzt1/table.h"
#include "devices/toshiba_mcu/framer.h"
#include "devices/toshiba_mcu/table.h"

namespace virtdrive {
namespace {

// For a line that carries no frames: each byte is by itself.
class ByteFramer final : public protocol::Framer {
 public:
  void push(protocol::Direction, std::uint8_t, std::vector<protocol::Run>& ended) override {
    ended.push_back({1, protocol::Verdict::kNoise, "bytes"});
  }
  void expire(protocol::Direction, std::vector<protocol::Run>&) override {}
  SimDuration silence() const override { return {}; }
};

std::unique_ptr<protocol::Framer> make_byte_framer() {
  return std::make_unique<ByteFramer>();
}

struct Entry {
  std::string_view protocol;
  std::unique_ptr<protocol::Framer> (*make)();
};

constexpr Entry kFramers[] = {{toshiba_mcu::kTable.name, toshiba_mcu::make_framer},
                              {md485::kTable.name, md485::make_framer},
                              {rzt1::kTable.name, rzt1::make_framer},
                              {asd7::kTable.name, asd7::make_framer},
                              {asd7_modbus::kTable.name, asd7_modbus::make_framer},
                              {kNoProtocol, make_byte_framer}};

}  // namespace

std::unique_ptr<protocol::Framer> make_framer(std::string_view protocol) {
  const auto* const it = std::ranges::find(kFramers, protocol, &Entry::protocol);
  VIRTDRIVE_CHECK(it != std::end(kFramers), "no framer of protocol '{}'", protocol);
  return it->make();
}

}  // namespace virtdrive
