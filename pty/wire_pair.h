// One pair of wires: who talks on it and who listens. A full-duplex line has two, a half-duplex
// one.
//
// While one talks and the others are set alike, each hears a character at the instant its last bit
// is out: nothing but a queue. As soon as it matters (two talk at once, somebody has other
// settings, a driver lets go in the middle of a character, the wires are held at a level) those
// concerned sample the level of the wires bit by bit, until all is quiet again.
//
// The electrical model: drivers are voltage sources of equal impedance, so that the majority of
// those who drive decides the level, and when they cancel each other out the differential voltage
// is about zero: inside the +-200 mV in which TIA/EIA-485 leaves a receiver's output open. Such an
// interval reads as a level that is drawn, the same for all. Where nobody drives, bias holds the
// wires high. A transceiver's receiver is off while its driver is on.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/event_loop.h"
#include "core/random.h"
#include "pty/line_faults.h"
#include "pty/line_settings.h"
#include "pty/uart.h"

namespace virtdrive {

struct LineCounters {
  std::uint64_t to_device = 0;       // bytes heard by devices, each one's counted
  std::uint64_t to_host = 0;         // bytes heard by the host end
  std::uint64_t to_device_lost = 0;  // dropped: too many characters were waiting to leave
  std::uint64_t to_host_lost = 0;
  std::uint64_t garbled = 0;  // bytes sent at a baud rate, size or parity that a listener has not
  std::uint64_t collisions = 0;  // times that somebody began to talk while another did
  // Faults that were asked for, in bytes.
  std::uint64_t fault_lost = 0;
  std::uint64_t fault_flipped = 0;
  std::uint64_t fault_duplicated = 0;
  std::uint64_t fault_delayed = 0;
  std::uint64_t noise = 0;
};

/// A transmitter: characters on their way, each with its exact time.
class Talker {
 public:
  /// Characters that may wait to leave.
  static constexpr std::size_t kMaxQueued = 65536;

  enum class Content : std::uint8_t { kByte, kWrongParity, kLost, kBreak };

  struct Character {
    SimTime begin;
    SimTime end;
    LineSettings settings;
    std::uint8_t byte;
    Content content;
  };

  /// First in, first out; a deque would allocate as often as it wraps.
  class Queue {
   public:
    bool empty() const { return head_ == characters_.size(); }
    std::size_t size() const { return characters_.size() - head_; }
    auto begin() const { return characters_.begin() + static_cast<std::ptrdiff_t>(head_); }
    auto end() const { return characters_.end(); }
    const Character& front() const { return characters_[head_]; }
    void push(const Character& character);
    void pop();
    void clear();

   private:
    std::vector<Character> characters_;  // those before head_ are gone
    std::size_t head_ = 0;
  };

  /// What it does with the wires from an instant on, and until when.
  struct Drive {
    enum class Level : std::uint8_t { kReleased, kLow, kHigh };

    Level level = Level::kReleased;
    SimTime until = kNever;
  };

  Talker(int id, std::uint64_t& dropped) : id_(id), dropped_(dropped) {}

  int id() const { return id_; }
  const Queue& queue() const { return queue_; }
  /// When the last bit is out; in the past if it does not talk.
  SimTime idle() const { return idle_; }
  Drive drive(SimTime t) const;

 private:
  friend class WirePair;

  void say(std::uint8_t byte, Content content, const LineSettings& settings, SimTime now);
  void hold_low(SimDuration duration, const LineSettings& settings, SimTime now);
  void pause(SimDuration duration, SimTime now);
  void let_go(SimTime now);

  int id_;
  std::uint64_t& dropped_;
  Queue queue_;
  LineSettings sender_;
  SimTime burst_start_ = kSimStart;
  std::int64_t burst_count_ = 0;  // characters of the burst so far
  SimTime idle_ = kSimStart;
  bool listed_ = false;  // among the pair's active ones
  bool cut_ = false;
};

/// A receiver.
class Listener {
 public:
  using Hear = std::function<void(const WireByte&)>;

  enum class Kind : std::uint8_t { kEnd, kTap };

  /// `own` is the transmitter beside it, for whose time it is deaf; nullptr: it always hears.
  Listener(Hear hear, const Talker* own, Kind kind = Kind::kEnd)
      : hear_(std::move(hear)), own_(own), kind_(kind) {}

 private:
  friend class WirePair;

  Hear hear_;
  const Talker* own_;
  Kind kind_;
  LineSettings settings_;
  bool on_ = false;
  bool sampling_ = false;
  SimTime direct_until_ = kNever;  // characters that end by then are heard without sampling
  Uart uart_;
};

class WirePair {
 public:
  /// `chance` and `counters` are the line's.
  WirePair(EventLoop& loop, RandomStream& chance, LineCounters& counters);
  WirePair(const WirePair&) = delete;
  WirePair& operator=(const WirePair&) = delete;

  /// Both must outlive the pair, and do not move.
  void add(Talker& talker) { talkers_.push_back(&talker); }
  void add(Listener& listener) { listeners_.push_back(&listener); }

  /// Says bytes behind what the talker is still saying; when the last bit will be out.
  SimTime send(Talker& talker, std::span<const std::uint8_t> bytes, const LineSettings& settings,
               const LineFaults* faults);
  /// Holds the wires low, behind what the talker is still saying.
  SimTime send_break(Talker& talker, SimDuration duration, const LineSettings& settings);
  /// The driver lets go where it is.
  void cut_off(Talker& talker);

  void switch_on(Listener& listener, const LineSettings& settings);
  void switch_off(Listener& listener);
  /// From now on; nothing while it is off.
  void tune(Listener& listener, const LineSettings& settings);

  void hold(LineStuck level);
  /// A talker that is cut goes on talking, and nobody hears it.
  void cut(Talker& talker, bool is_cut);
  void set_noise(double per_s, const LineSettings& settings);

 private:
  void run();
  void hear_directly();
  void hear_directly(const Talker& talker, const Talker::Character& character);
  void hear_untimed(const Talker& talker, std::vector<Talker::Character> said);
  void hear_samples();
  void settle();
  void schedule();

  bool begin(Talker& talker, const LineSettings& settings);
  SimTime queued(Talker& talker);
  void utter(Talker& talker, std::uint8_t byte, const LineSettings& settings,
             const LineFaults& faults);
  bool happens(double probability) { return probability > 0 && chance_.uniform() < probability; }
  void begin_anew(Listener& listener);
  bool somebody_talks() const;
  void sample_all();
  void sample(Listener& listener, SimTime from);
  void stop_sampling(Listener& listener);
  SimTime in_flight_since() const;
  void log_until(SimTime t);
  void look_again();
  void make_noise();
  void draw_next_noise();

  EventLoop& loop_;
  RandomStream& chance_;
  LineCounters& counters_;
  std::vector<Talker*> talkers_;
  std::vector<Talker*> active_;  // those with characters in their queues
  std::vector<Listener*> listeners_;
  std::vector<Talker::Character> untimed_;  // of an ideal line, heard at this instant
  std::uint64_t noise_dropped_ = 0;         // never: it is made while nobody talks
  Talker noise_{kNoTalker, noise_dropped_};
  double noise_per_s_ = 0;
  LineSettings noise_settings_;
  SimTime next_noise_ = kNever;
  LineStuck stuck_ = LineStuck::kNo;
  // While anybody samples:
  std::size_t sampling_ = 0;
  Levels levels_;
  SimTime logged_ = kSimStart;  // the levels are known up to here
  SimTime clash_begin_ = kSimStart;
  SimTime clash_end_ = kSimStart;  // of the last interval in which several drove the wires
  Wakeup wakeup_;
};

}  // namespace virtdrive
