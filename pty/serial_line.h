// A serial wire in virtual time: a host end and any number of devices. No file descriptor, no wall
// clock.
//
//   full duplex   host ----> every device     RS-232, TTL, RS-422 and RS-485 with four wires
//                 host <---- every device
//   half duplex   host <---> every device     RS-485 with two wires: everybody hears everybody else
//
// A byte is heard in Phase::kBytes at the instant its last bit has arrived: character n of a burst
// that starts at t arrives at t + (n + 1) character times, computed from the burst's start, so that
// no rounding adds up. Who is set to another baud rate, size or parity hears, and causes, what
// hardware would give: garbage, and silence where a receiver checks a parity that is wrong. So do
// two that talk at once on the same wires (wire_pair.h has the electrical model); on an ideal line,
// where nothing takes time, nothing collides.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/event_loop.h"
#include "core/random.h"
#include "devices/serial_port.h"
#include "pty/line_faults.h"
#include "pty/line_settings.h"
#include "pty/wire_pair.h"

namespace virtdrive {

enum class Duplex : std::uint8_t { kFull, kHalf };

struct LineOptions {
  Duplex duplex = Duplex::kFull;
  bool echo = false;       // half duplex: the host's adapter hears itself
  RandomStream chance{0};  // for collisions and faults, e.g. Seed::stream("line")
};

class SerialLine;

/// A device's place on a line: its transmitter, and its receiver's. Owned by the line.
class LineEnd final : public SerialPort {
 public:
  LineEnd(SerialLine& line, int number, const LineSettings& settings);
  LineEnd(const LineEnd&) = delete;
  LineEnd& operator=(const LineEnd&) = delete;

  /// Power on: hears from now on, from the middle of a character if one is under way. The receiver
  /// must outlive the line, or be detached. Another one takes its place at once.
  void attach(SerialReceiver& device);
  /// Power off: hears nothing, and its transmitter lets go in the middle of a character if it
  /// talks.
  void detach();
  bool attached() const { return device_ != nullptr; }

  /// Nothing happens while no device is attached.
  SimTime send(std::span<const std::uint8_t> bytes) override;

  /// What is queued keeps its settings. The timing is the line's.
  void set_baud(int baud) override;
  void set_parity(Parity parity) override;
  void set_settings(const LineSettings& settings);
  const LineSettings& settings() const { return settings_; }

  /// Others hang on the same line.
  bool shared() const;
  /// From 0, in the order in which devices were added.
  int number() const { return talker_.id(); }

 private:
  friend class SerialLine;

  void hear(const WireByte& byte);

  SerialLine& line_;
  LineSettings settings_;
  SerialReceiver* device_ = nullptr;
  Talker talker_;
  Listener listener_;
};

class SerialLine {
 public:
  /// Characters that may wait to leave, of each who talks.
  static constexpr std::size_t kMaxQueued = Talker::kMaxQueued;

  /// `settings` are those of the host, and of devices that are added without their own.
  SerialLine(EventLoop& loop, const LineSettings& settings, LineOptions options = {});
  SerialLine(const SerialLine&) = delete;
  SerialLine& operator=(const SerialLine&) = delete;
  ~SerialLine();

  /// Another device, for the life of the line.
  LineEnd& add_device();
  LineEnd& add_device(const LineSettings& settings);
  std::size_t devices() const { return devices_.size(); }
  LineEnd& device(std::size_t number) { return *devices_.at(number); }

  /// The host starts to send now, behind what is still leaving.
  void host_send(std::span<const std::uint8_t> bytes);
  /// The host holds the line low for so long, behind what is still leaving: a receiver reads a 0x00
  /// without stop bit.
  void host_break(SimDuration duration);
  /// The host end hears a byte and the instant of its last bit. One listener; empty: none.
  using HostListener = std::function<void(std::uint8_t, SimTime)>;
  /// Returns the listener it replaces.
  HostListener on_host_byte(HostListener listener) {
    return std::exchange(host_listener_, std::move(listener));
  }

  /// What a recording needs in order to replay a live host: each host_send, as it was called, and
  /// each set_host, with no bytes.
  using HostTap = std::function<void(std::span<const std::uint8_t>, const HostSettings&, SimTime)>;
  void on_host_send(HostTap tap) { host_tap_ = std::move(tap); }

  /// A logic analyser on the wires, set as the line: each byte that passes, in the order of their
  /// last bits, with who said it. Empty: none.
  using WireTap = std::function<void(const WireByte&)>;
  void on_wire(WireTap tap);

  /// What is queued keeps its settings.
  void set_host(const HostSettings& host);

  /// For what is sent from now on; noise, stuck and cut lines at once.
  void set_faults(LineDirection direction, const LineFaults& faults);
  const LineFaults& faults(LineDirection direction) const {
    return faults_[static_cast<std::size_t>(direction)];
  }

  /// The first device's, or those of the line while it has none: what a host needs.
  const LineSettings& settings() const { return settings_; }
  const HostSettings& host() const { return host_; }
  const LineOptions& options() const { return options_; }
  const LineCounters& counters() const { return counters_; }
  /// Characters from the host that have not arrived yet.
  std::size_t host_backlog() const { return host_talker_.queue().size(); }

 private:
  friend class LineEnd;

  WirePair& wires(LineDirection direction);
  const LineFaults* active_faults(LineDirection direction) const;
  void set_line(const LineSettings& settings);
  LineSettings host_line() const;
  void hear_at_host(const WireByte& byte);
  void apply_wire_faults();

  EventLoop& loop_;
  LineSettings settings_;
  LineOptions options_;
  HostSettings host_;
  LineCounters counters_;
  HostListener host_listener_;
  HostTap host_tap_;
  WireTap wire_tap_;
  std::array<LineFaults, 2> faults_;
  std::array<bool, 2> faulty_{};  // whether bytes of that direction need to draw
  Talker host_talker_;
  Listener host_ear_;
  std::vector<std::unique_ptr<Listener>> taps_;  // one on each pair
  std::vector<std::unique_ptr<LineEnd>> devices_;
  std::vector<std::unique_ptr<WirePair>> pairs_;  // full duplex: to the devices, to the host
};

}  // namespace virtdrive
