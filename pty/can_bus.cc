#include "pty/can_bus.h"

#include <algorithm>
#include <utility>

namespace virtdrive {
namespace {

// Recessive and unstuffed: CRC delimiter, acknowledge slot and its delimiter, end of frame, gap.
constexpr int kTailBits = 1 + 1 + 1 + 7 + 3;
// An error frame on the average: the bits up to it, the flags of all, the delimiter, the gap; who
// is error passive waits eight more.
constexpr int kErrorBits = 6 + 6 + 8 + 3;
constexpr int kSuspendBits = 8;

constexpr int kPassiveAbove = 127;
constexpr int kOffAbove = 255;

SimDuration time_of(int bits, int bit_rate) {
  return from_seconds(static_cast<double>(bits) / bit_rate);
}

// Bits up to the end of the CRC: they go through the stuffing.
class StuffedBits {
 public:
  void push(std::uint32_t value, int bits) {
    for (int i = bits - 1; i >= 0; --i) push_bit((value >> i & 1) != 0);
  }
  void push_crc() { push(crc_, 15); }
  int count() const { return count_; }

 private:
  void push_bit(bool bit) {
    const bool invert = bit != ((crc_ >> 14 & 1) != 0);
    crc_ = (crc_ << 1 & 0x7FFF) ^ (invert ? 0x4599U : 0U);
    ++count_;
    run_ = bit == last_ ? run_ + 1 : 1;
    last_ = bit;
    if (run_ < 5) return;
    ++count_;  // the stuff bit, which begins a run of its own
    last_ = !bit;
    run_ = 1;
  }

  std::uint32_t crc_ = 0;
  int count_ = 0;
  bool last_ = true;
  int run_ = 0;
};

// What decides who goes on: 0 is dominant, so the smaller one wins. A standard frame beats the
// extended one with the same first 11 bits, a data frame the remote one.
std::uint64_t priority(const CanFrame& frame) {
  const std::uint64_t base = frame.extended ? frame.id >> 18 : frame.id;
  if (!frame.extended) return base << 21 | std::uint64_t{frame.remote} << 20;
  return base << 21 | std::uint64_t{3} << 19 | std::uint64_t{frame.id & 0x3FFFF} << 1 |
         std::uint64_t{frame.remote};
}

}  // namespace

int can_frame_bits(const CanFrame& frame) {
  StuffedBits bits;
  bits.push(0, 1);
  if (frame.extended) {
    bits.push(frame.id >> 18, 11);
    bits.push(3, 2);  // SRR, IDE
    bits.push(frame.id & 0x3FFFF, 18);
    bits.push(frame.remote, 1);
    bits.push(0, 2);
  } else {
    bits.push(frame.id, 11);
    bits.push(frame.remote, 1);
    bits.push(0, 2);
  }
  bits.push(frame.length, 4);
  for (const std::uint8_t byte : frame.bytes()) bits.push(byte, 8);
  bits.push_crc();
  return bits.count() + kTailBits;
}

// --- One controller ------------------------------------------------------------------------------

void CanNode::detach() {
  close();
  device_ = nullptr;
}

void CanNode::open(int bit_rate, bool listen_only) {
  close();
  bit_rate_ = bit_rate;
  listen_only_ = listen_only;
  state_ = {};
}

void CanNode::close() {
  bit_rate_ = 0;
  waiting_.clear();
  std::erase(bus_.senders_, this);
}

bool CanNode::send(const CanFrame& frame) {
  if (!takes_part() || listen_only_ || waiting_.size() >= kMaxQueued) return false;
  waiting_.push_back(frame);
  bus_.next();
  return true;
}

// An error passive sender that only nobody acknowledges counts no further (ISO 11898-1, 12.1.4.2).
void CanNode::transmit_failed(bool no_acknowledge) {
  if (!no_acknowledge || state_.transmit_errors <= kPassiveAbove) state_.transmit_errors += 8;
  if (state_.transmit_errors <= kOffAbove) return;
  state_.bus_off = true;
  waiting_.clear();
}

// --- All of them ---------------------------------------------------------------------------------

CanBus::CanBus(EventLoop& loop) : loop_(loop), wake_(loop.add(Phase::kBytes, [this] { wake(); })) {}

CanNode& CanBus::add_node() {
  return *nodes_.emplace_back(std::make_unique<CanNode>(*this));
}

bool CanBus::sends(const CanNode& node) const {
  return std::ranges::find(senders_, &node) != senders_.end();
}

void CanBus::wake() {
  if (!senders_.empty()) end();
  begin();
}

// Who begins to send in one instant begins together.
void CanBus::next() {
  if (wake_.due() == kNever) wake_.at(std::max(free_, loop_.now()));
}

void CanBus::begin() {
  senders_.clear();
  if (loop_.now() < free_) return next();
  std::uint64_t best = UINT64_MAX;
  for (const auto& node : nodes_) {
    if (node->wants_to_send()) best = std::min(best, priority(node->waiting_.front()));
  }
  if (best == UINT64_MAX) return;
  for (const auto& node : nodes_) {
    if (node->wants_to_send() && priority(node->waiting_.front()) == best) {
      senders_.push_back(node.get());
    }
  }
  const CanFrame& frame = senders_.front()->waiting_.front();
  free_ = loop_.now() + time_of(can_frame_bits(frame), senders_.front()->bit_rate_);
  wake_.at(free_);
}

void CanBus::end() {
  const CanFrame frame = senders_.front()->waiting_.front();
  const bool same = std::ranges::all_of(
      senders_, [&](const CanNode* sender) { return sender->waiting_.front() == frame; });
  if (!same || destroyed_by_others()) return fail(false);
  if (!acknowledged()) return fail(true);
  ++counters_.frames;
  for (CanNode* const sender : senders_) {
    sender->waiting_.pop_front();
    sender->state_.transmit_errors = std::max(0, sender->state_.transmit_errors - 1);
  }
  deliver(frame);
}

// By somebody at another bit rate, who takes what passes for an error and says so.
bool CanBus::destroyed_by_others() const {
  const int rate = senders_.front()->bit_rate_;
  return !cut_ && std::ranges::any_of(nodes_, [&](const auto& node) {
    return node->takes_part() && !node->listen_only_ && node->bit_rate_ != rate &&
           (sends(*node) || !node->state_.passive());
  });
}

bool CanBus::acknowledged() const {
  const int rate = senders_.front()->bit_rate_;
  return !cut_ && std::ranges::any_of(nodes_, [&](const auto& node) {
    return node->takes_part() && !node->listen_only_ && node->bit_rate_ == rate &&
           (senders_.size() > 1 || !sends(*node));
  });
}

void CanBus::deliver(const CanFrame& frame) {
  const int rate = senders_.front()->bit_rate_;
  const std::vector<CanNode*> senders = std::exchange(senders_, {});
  for (const auto& node : nodes_) {
    const bool sent = std::ranges::find(senders, node.get()) != senders.end();
    if (sent || !node->takes_part() || node->bit_rate_ != rate) continue;
    node->state_.receive_errors = std::max(0, std::min(node->state_.receive_errors, 128) - 1);
    if (node->device_ != nullptr) node->device_->receive(frame);
  }
}

void CanBus::fail(bool no_acknowledge) {
  ++counters_.errors;
  const int rate = senders_.front()->bit_rate_;
  bool passive = false;
  for (const auto& node : nodes_) {
    if (!node->takes_part() || (cut_ && !sends(*node))) continue;
    if (sends(*node)) {
      passive = passive || node->state_.passive();
      node->transmit_failed(no_acknowledge);
    } else if (!node->listen_only_) {
      // Who saw the error first counts eight, the others one.
      node->state_.receive_errors =
          std::min(node->state_.receive_errors + (node->bit_rate_ != rate ? 8 : 1), 135);
    }
  }
  senders_.clear();
  free_ = loop_.now() + time_of(kErrorBits + (passive ? kSuspendBits : 0), rate);
}

}  // namespace virtdrive
