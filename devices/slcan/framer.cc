#include "devices/slcan/framer.h"

#include <string>
#include <utility>

#include "devices/slcan/table.h"

namespace virtdrive::slcan {
namespace {

using protocol::Direction;
using protocol::Run;
using protocol::Verdict;

class LineFramer final : public protocol::Framer {
 public:
  void push(Direction direction, std::uint8_t byte, std::vector<Run>& ended) override {
    std::string& held = lane(direction);
    if (byte == kOk || byte == kError) {
      const std::size_t size = held.size() + 1;
      const std::string_view end = byte == kOk ? "" : "refused";
      ended.push_back({size, Verdict::kFrame, std::exchange(held, {}).append(end)});
      return;
    }
    held += byte >= ' ' && byte <= '~' ? static_cast<char>(byte) : '?';
    if (held.size() <= kLongestReply) return;
    ended.push_back({held.size(), Verdict::kNoise, "no end of a line"});
    held.clear();
  }

  void expire(Direction direction, std::vector<Run>& ended) override {
    std::string& held = lane(direction);
    if (held.empty()) return;
    ended.push_back({held.size(), Verdict::kCutShort, "no end of the line"});
    held.clear();
  }

  SimDuration silence() const override { return {}; }

 private:
  static constexpr std::size_t kLongestReply = kLongest + 4;  // with the time behind it

  std::string& lane(Direction direction) {
    return direction == Direction::kRequest ? requests_ : replies_;
  }

  std::string requests_, replies_;
};

}  // namespace

std::unique_ptr<protocol::Framer> make_framer() {
  return std::make_unique<LineFramer>();
}

}  // namespace virtdrive::slcan
