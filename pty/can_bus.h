// A CAN 2.0 bus in virtual time: any number of controllers on two wires, frame by frame.
//
//   arbitration    who has the lowest identifier goes first; the others wait, nothing is lost
//   bit times      each frame takes what its bits take, stuff bits and the gap behind it included
//   acknowledge    a frame that nobody else at its bit rate takes is an error, and is sent again
//   errors         count up and down as ISO 11898-1 has it: error passive above 127, off above 255
//
// Two that send one identifier at once both go on while their bits are the same: equal frames are
// one frame, others an error for both. Who is set to another bit rate hears garbage, and destroys
// what the others say until it is error passive. Nothing is looked at bit by bit: an error takes
// the time of its error frame.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <vector>

#include "core/event_loop.h"
#include "devices/can_port.h"

namespace virtdrive {

/// Bits of a frame on the wire, from the start of frame to the gap of three behind it.
int can_frame_bits(const CanFrame& frame);

struct CanCounters {
  std::uint64_t frames = 0;  // that somebody took
  std::uint64_t errors = 0;  // error frames
};

class CanBus;

/// A device's place on the bus. Owned by the bus. Off the bus until it is opened.
class CanNode final : public CanPort {
 public:
  /// Frames that may wait to leave.
  static constexpr std::size_t kMaxQueued = 32;

  explicit CanNode(CanBus& bus) : bus_(bus) {}
  CanNode(const CanNode&) = delete;
  CanNode& operator=(const CanNode&) = delete;

  /// Must outlive the bus, or be detached.
  void attach(CanReceiver& device) { device_ = &device; }
  void detach();

  void open(int bit_rate, bool listen_only) override;
  void close() override;
  bool send(const CanFrame& frame) override;
  CanState state() const override { return state_; }
  bool is_open() const { return bit_rate_ > 0; }

 private:
  friend class CanBus;

  bool takes_part() const { return is_open() && !state_.bus_off; }
  bool wants_to_send() const { return takes_part() && !waiting_.empty(); }
  void transmit_failed(bool no_acknowledge);

  CanBus& bus_;
  CanReceiver* device_ = nullptr;
  int bit_rate_ = 0;  // bit/s; 0: closed
  bool listen_only_ = false;
  CanState state_;
  std::deque<CanFrame> waiting_;
};

class CanBus {
 public:
  explicit CanBus(EventLoop& loop);
  CanBus(const CanBus&) = delete;
  CanBus& operator=(const CanBus&) = delete;

  CanNode& add_node();
  const CanCounters& counters() const { return counters_; }
  /// The wires are cut: nobody hears anybody.
  void set_cut(bool cut) { cut_ = cut; }
  bool cut() const { return cut_; }

 private:
  friend class CanNode;

  void wake();
  void next();
  void begin();
  void end();
  bool destroyed_by_others() const;
  bool acknowledged() const;
  void deliver(const CanFrame& frame);
  void fail(bool no_acknowledge);
  bool sends(const CanNode& node) const;

  EventLoop& loop_;
  std::vector<std::unique_ptr<CanNode>> nodes_;
  std::vector<CanNode*> senders_;  // of the frame under way
  SimTime free_ = kSimStart;       // when the next one may begin
  bool cut_ = false;
  CanCounters counters_;
  Wakeup wake_;
};

}  // namespace virtdrive
