// The two oscilloscopes of the firmware: a snapshot that the host fetches (ConfigDSOLog,
// GetDSOLogData: 4.2.6, 4.2.7) and a stream on a second serial line (ConfigureHsDSO: 4.2.8).
//
// Both look at one channel, once each PWM interrupt or each (spread + 1)-th, and log the selected
// signals in ascending bit order. Without PWM interrupts, with the motor stopped, nothing comes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware_models/toshiba_mcu/settings.h"
#include "firmware_models/toshiba_mcu/stage.h"

namespace virtdrive::toshiba_mcu {

class MotorChannel;

inline constexpr unsigned kScopeSignals = 32;

/// The name of a bit of selected_values: "Va", "Iq_Ref", "User1".
std::string_view scope_signal_name(unsigned bit);
/// What the bit shows, in the registers' scale (Q15 of full scale, most of them).
std::string_view scope_signal_doc(unsigned bit);
/// The signal as the program logs it; beyond 16 bits it stays at the end.
std::int16_t scope_value(const MotorChannel& channel, unsigned bit);

/// A selection of signals and how often they are logged.
class ScopeChannels {
 public:
  ScopeChannels() = default;
  ScopeChannels(std::size_t motor, std::uint32_t selected, std::uint8_t spread);

  std::size_t motor() const { return motor_; }
  std::size_t size() const { return count_; }
  /// True at the periods that are logged.
  bool due();
  /// The values of one set; valid until the next call.
  std::span<const std::int16_t> sample(const MotorChannel& channel);

 private:
  std::size_t motor_ = 0;
  std::uint8_t spread_ = 0;
  std::uint8_t waited_ = 0;
  std::size_t count_ = 0;
  std::array<std::uint8_t, kScopeSignals> bits_{};
  std::array<std::int16_t, kScopeSignals> values_{};
};

class SnapshotScope {
 public:
  static constexpr std::size_t kBlock = 16;  // values that one telegram carries
  static constexpr int kMostSignals = 16;

  struct Request {
    std::size_t motor = 0;
    std::uint32_t selected = 0;
    std::uint32_t trigger_on = 0;  // 0: at once; of several bits the highest counts
    std::uint8_t mode = 0;         // bit 0 rising edge, else falling; bit 1 centred, else left
    std::int16_t level = 0;
    std::uint8_t spread = 0;
  };

  /// Begins anew. The number of blocks that the host can fetch when it is done; 0, and nothing
  /// armed, for no signal or more than 16.
  std::uint16_t arm(const Request& request);
  /// After a PWM interrupt of a channel.
  void sample(std::size_t motor, const MotorChannel& channel) {
    if (logging_ && motor == channels_.motor()) log(channel);
  }
  /// kNotReady while it waits or samples; kRefused when there is nothing (more) to fetch. A last
  /// block that is not full goes on from the start of the ring.
  Outcome next_block(std::array<std::int16_t, kBlock>& block);

 private:
  void log(const MotorChannel& channel);
  bool triggers(std::int16_t value);

  Request request_;
  ScopeChannels channels_;
  bool logging_ = false;
  unsigned trigger_bit_ = 0;
  bool triggered_ = false;
  bool first_ = true;  // no value to compare with yet
  std::int16_t last_ = 0;
  std::vector<std::int16_t> ring_;
  std::size_t at_ = 0;       // where the next set goes
  std::size_t sets_ = 0;     // logged so far, up to the ring's
  std::size_t to_come_ = 0;  // sets after the trigger
  std::size_t start_ = 0;    // of the oldest set, once all is logged
  std::size_t fetched_ = 0;  // blocks
  std::size_t blocks_ = 0;
};

class StreamScope {
 public:
  /// Where sets go; `timestamp` counts the channel's PWM periods modulo PwmFrequency.
  using Sink = std::function<void(std::uint16_t timestamp, std::span<const std::int16_t> values)>;

  void set_sink(Sink sink) { sink_ = std::move(sink); }
  /// kRefused for no signal.
  Outcome enable(std::size_t motor, std::uint32_t selected, std::uint8_t spread);
  void disable() { enabled_ = false; }
  void sample(std::size_t motor, const MotorChannel& channel) {
    if (enabled_ && motor == channels_.motor()) stream(channel);
  }

 private:
  void stream(const MotorChannel& channel);

  Sink sink_;
  bool enabled_ = false;
  ScopeChannels channels_;
  std::uint32_t periods_ = 0;
};

}  // namespace virtdrive::toshiba_mcu
