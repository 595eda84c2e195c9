// A serial wire in virtual time, point to point and full duplex. No file descriptor, no wall clock.
//
//   host end                                device end
//   host_send(bytes)  ---- characters ---->  SerialReceiver::receive(byte)
//   on_host_byte(...)  <--- characters ----  device_port().send(bytes)
//
// A byte is heard in Phase::kBytes at the instant its last bit has arrived: character n of a burst
// that starts at t arrives at t + (n + 1) character times, computed from the burst's start, so that
// no rounding adds up. A host set to another baud rate, size or parity hears, and causes, what
// hardware would give: garbage, and silence where a receiver checks a parity that is wrong.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/event_loop.h"
#include "devices/serial_port.h"

namespace virtdrive {

enum class LineTiming : std::uint8_t { kReal, kIdeal };  // kIdeal: no character times
enum class Parity : std::uint8_t { kNone, kEven, kOdd };

struct LineSettings {
  LineTiming timing = LineTiming::kReal;
  int baud = 115200;  // bit/s, > 0
  int data_bits = 8;  // 5..8
  Parity parity = Parity::kNone;
  int stop_bits = 1;  // 1 or 2

  /// Bit times from start to stop bit: 10 for 8N1.
  int character_bits() const {
    return 1 + data_bits + (parity == Parity::kNone ? 0 : 1) + stop_bits;
  }
  /// How long `count` characters take, rounded down to 1 ns; 0 on an ideal line.
  SimDuration time_of(std::int64_t count) const;
  SimDuration character_time() const { return time_of(1); }

  friend bool operator==(const LineSettings&, const LineSettings&) = default;
};

/// What the host has set its own end to; 0 or nothing: the same as the line. A pseudo-terminal lets
/// only the first two be seen, RFC 2217 all of them.
struct HostSettings {
  int baud = 0;
  int stop_bits = 0;
  int data_bits = 0;
  std::optional<Parity> parity = std::nullopt;

  friend bool operator==(const HostSettings&, const HostSettings&) = default;
};

/// A byte as a receiver with other settings reads it.
struct ResampledByte {
  std::uint8_t byte = 0;
  SimDuration arrival{};  // end of its stop bit, from the start of the burst
  bool error = false;     // stop bit low or parity wrong

  friend bool operator==(const ResampledByte&, const ResampledByte&) = default;
};

/// What a UART set as `listener` makes of a burst sent by one set as `sender`: it waits for a
/// falling edge and samples in the middle of each of its own bits; after a low stop bit it waits
/// for a high line. The line is idle before and after. Baud rates up to about 5 % apart give the
/// bytes back unchanged.
std::vector<ResampledByte> resample(std::span<const std::uint8_t> bytes, const LineSettings& sender,
                                    const LineSettings& listener);

struct LineCounters {
  std::uint64_t to_device = 0;       // bytes heard by the device
  std::uint64_t to_host = 0;         // bytes heard by the host end
  std::uint64_t to_device_lost = 0;  // dropped: kMaxQueued characters were waiting to leave
  std::uint64_t to_host_lost = 0;
  std::uint64_t garbled = 0;  // bytes sent at a baud rate, size or parity the other end has not
};

class SerialLine {
 public:
  /// Characters that may wait in each direction.
  static constexpr std::size_t kMaxQueued = 65536;
  /// Baud rates this close are taken as equal: crystals and divisors differ by that much.
  static constexpr double kBaudTolerance = 0.03;

  SerialLine(EventLoop& loop, const LineSettings& settings);
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;

  /// Who hears what the host sends. The device must outlive the line, or be replaced.
  void attach(SerialReceiver& device) { device_ = &device; }
  /// The device's transmitter.
  SerialPort& device_port() { return port_; }

  /// The host starts to send now, behind what is still leaving.
  void host_send(std::span<const std::uint8_t> bytes);
  /// The host end hears a byte and the instant of its last bit. One listener; empty: none.
  using HostListener = std::function<void(std::uint8_t, SimTime)>;
  /// Returns the listener it replaces.
  HostListener on_host_byte(HostListener listener) {
    return std::exchange(host_listener_, std::move(listener));
  }

  /// What a recording needs in order to replay a live host: each host_send, as it was called.
  using HostTap = std::function<void(std::span<const std::uint8_t>, const HostSettings&, SimTime)>;
  void on_host_send(HostTap tap) { host_tap_ = std::move(tap); }

  /// The device changes its baud rate, the host its settings; characters already queued keep
  /// theirs.
  void set_baud(int baud);
  void set_host(const HostSettings& host);

  const LineSettings& settings() const { return settings_; }
  const HostSettings& host() const { return host_; }
  const LineCounters& counters() const { return counters_; }
  /// Characters from the host that have not arrived yet.
  std::size_t host_backlog() const { return to_device_.size(); }

 private:
  // One direction: characters on their way, each with the instant of its last bit.
  class Lane {
   public:
    Lane(EventLoop& loop, std::uint64_t* lost, std::function<void(std::uint8_t)> deliver);

    SimTime send(std::span<const std::uint8_t> bytes, const LineSettings& sender);
    SimTime send(std::span<const ResampledByte> heard, std::size_t sent,
                 const LineSettings& sender);
    std::size_t size() const { return characters_.size(); }

   private:
    struct Character {
      SimTime arrival;
      std::uint8_t byte;
    };

    void start(const LineSettings& sender);
    void leave(std::size_t count);
    void push(std::uint8_t byte, SimTime arrival);
    void deliver_due();

    EventLoop& loop_;
    std::uint64_t* lost_;
    std::function<void(std::uint8_t)> deliver_;
    std::deque<Character> characters_;
    LineSettings sender_;
    SimTime burst_start_ = kSimStart;
    std::int64_t burst_count_ = 0;  // characters of the burst so far
    SimTime idle_ = kSimStart;      // when the last bit is out
    Wakeup wakeup_;
  };

  class Port final : public SerialPort {
   public:
    explicit Port(SerialLine& line) : line_(line) {}
    SimTime send(std::span<const std::uint8_t> bytes) override { return line_.device_send(bytes); }

   private:
    SerialLine& line_;
  };

  SimTime device_send(std::span<const std::uint8_t> bytes);
  SimTime carry(Lane& lane, std::span<const std::uint8_t> bytes, const LineSettings& sender,
                const LineSettings& listener);
  LineSettings host_line() const;

  EventLoop& loop_;
  LineSettings settings_;
  HostSettings host_;
  LineCounters counters_;
  SerialReceiver* device_ = nullptr;
  HostListener host_listener_;
  HostTap host_tap_;
  Port port_{*this};
  Lane to_device_;
  Lane to_host_;
};

}  // namespace virtdrive
