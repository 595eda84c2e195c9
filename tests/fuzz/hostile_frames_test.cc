// Millions of frames that are almost right, through the whole drive on an ideal line. A model of
// the drive's receiver, written from the document and with a table of lengths of its own, says for
// each frame whether there must be an answer and of what kind; the answers must be whole telegrams,
// and after each burst a good request must be answered as the drive would: at once if its receiver
// is idle, or else swallowed by the telegram that was cut short.
//
// VIRTDRIVE_FRAMES is how many: 50,000 in every build, 10 million in ./dev long.
#include <array>
#include <chrono>
#include <cstdio>
#include <deque>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

#include "core/random.h"
#include "scenarios/bench.h"
#include "tests/devices/vectors.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t kBot = 0x11, kEot = 0x13, kError = 0xEE, kCrcError = 0x01;
constexpr std::uint64_t kFrames = VIRTDRIVE_FRAMES;

struct Lengths {
  int request = -1;
  int reply = -1;
};

// Payload bytes of each command (4.2.1 to 4.2.24).
constexpr std::array<Lengths, 256> make_lengths() {
  std::array<Lengths, 256> lengths{};
  lengths[0x00] = lengths[0x01] = lengths[0x03] = lengths[0x04] = {1, 1};
  lengths[0x02] = {1, 20};
  lengths[0x05] = {13, 2};
  lengths[0x06] = {1, 32};
  lengths[0x07] = {7, 1};
  lengths[0x08] = {5, 1};
  lengths[0x09] = {3, 5};
  lengths[0x0A] = {7, 1};
  lengths[0x0B] = {18, 42};
  lengths[0x0C] = {50, 2};
  lengths[0x0D] = {7, 1};
  lengths[0x0E] = lengths[0x13] = {1, 4};
  lengths[0x0F] = lengths[0x10] = lengths[0x11] = lengths[0x21] = lengths[0x22] = {1, 1};
  lengths[0x12] = {2, 1};
  lengths[0x14] = {1, 2};
  lengths[0x23] = {1, 21};
  return lengths;
}
constexpr std::array<Lengths, 256> kLengths = make_lengths();

// Chapter 6: polynomial 0x07, not reflected, the command is the start value.
std::uint8_t crc8(std::span<const std::uint8_t> command_and_payload) {
  unsigned crc = command_and_payload[0];
  for (const std::uint8_t byte : command_and_payload.subspan(1)) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80) != 0 ? (crc << 1 ^ 0x107) : crc << 1;
  }
  return static_cast<std::uint8_t>(crc);
}

Bytes telegram(std::uint8_t command, std::span<const std::uint8_t> payload) {
  Bytes bytes = {kBot, command};
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  bytes.push_back(crc8(std::span(bytes).subspan(1)));
  bytes.push_back(kEot);
  return bytes;
}

// What must come: the answer to a command (or a refusal), or the error telegram of a wrong CRC.
struct Expected {
  std::uint8_t command = 0;
  bool crc_error = false;
};

// The receiver as the document and the published firmware have it: no time-out, one request at a
// time, deaf from a request's last byte until the answer is out, but for one byte in the UART.
class Receiver {
 public:
  void hear(std::span<const std::uint8_t> at_one_instant) {
    bool busy = false;
    std::optional<std::uint8_t> kept;
    for (const std::uint8_t byte : at_one_instant) {
      if (!busy)
        busy = take(byte);
      else if (!kept)
        kept = byte;
    }
    if (kept) take(*kept);
  }
  /// Bytes that the telegram under way lacks, or at least one.
  bool idle() const { return bytes_.empty(); }
  std::deque<Expected> answers;

 private:
  bool take(std::uint8_t byte) {
    if (bytes_.empty() && byte != kBot) return false;
    bytes_.push_back(byte);
    if (bytes_.size() < 2) return false;
    const int payload = kLengths[bytes_[1]].request;
    if (payload < 0) {
      bytes_.clear();
      return false;
    }
    const auto size = static_cast<std::size_t>(payload) + 4;
    if (bytes_.size() < size) return false;
    const bool end_fits = bytes_[size - 1] == kEot;
    const bool crc_fits = crc8(std::span(bytes_).subspan(1, size - 3)) == bytes_[size - 2];
    if (end_fits) answers.push_back({bytes_[1], !crc_fits});
    bytes_.clear();
    return end_fits;
  }

  Bytes bytes_;
};

// Frames that are right, and what a bad line or a bad program makes of them.
class Hostile {
 public:
  explicit Hostile(RandomStream random) : random_(std::move(random)) {
    for (const Vector& vector : read_vectors("vectors_toshiba_mcu.csv")) {
      const bool whole = vector.bytes.size() >= 5;  // some show how a frame is cut short
      if (vector.direction == "request" && whole) vectors_.push_back(vector.bytes);
    }
  }

  bool has_vectors() const { return !vectors_.empty(); }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(random_.bits() % n); }

  Bytes frame() {
    Bytes bytes = good();
    switch (below(12)) {
      case 0:
      case 1:  // as it is
        break;
      case 2:  // bits flip
        for (std::size_t n = 1 + below(3); n > 0; --n)
          any(bytes) ^= static_cast<std::uint8_t>(1U << below(8));
        break;
      case 3:  // cut short, before or behind
        bytes.resize(below(bytes.size()));
        break;
      case 4:
        bytes.erase(bytes.begin(),
                    bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size())));
        break;
      case 5: {  // the head of one, the tail of another
        const Bytes other = good();
        bytes.resize(below(bytes.size() + 1));
        bytes.insert(bytes.end(), other.begin() + static_cast<std::ptrdiff_t>(below(other.size())),
                     other.end());
        break;
      }
      case 6:  // bytes twice
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size())), any(bytes));
        break;
      case 7:  // bytes lost
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size())));
        break;
      case 8:  // a wrong CRC, or a wrong end
        bytes[bytes.size() - 1 - below(2)] = byte();
        break;
      case 9:  // another command's length; the CRC fits
        bytes = telegram(static_cast<std::uint8_t>(below(0x24)),
                         std::span(bytes).subspan(2, bytes.size() - 4));
        break;
      case 10: {  // a count that lies, values out of range; the CRC fits
        Bytes payload(bytes.begin() + 2, bytes.end() - 2);
        for (std::size_t n = 1 + below(4); n > 0; --n) any(payload) = byte();
        bytes = telegram(bytes[1], payload);
        break;
      }
      default:  // noise
        bytes.assign(below(40), 0);
        for (std::uint8_t& each : bytes) each = below(4) == 0 ? kBot : byte();
        break;
    }
    return bytes;
  }

 private:
  std::uint8_t byte() { return static_cast<std::uint8_t>(random_.bits()); }
  std::uint8_t& any(Bytes& bytes) { return bytes[below(bytes.size())]; }

  Bytes good() {
    if (below(2) == 0) return vectors_[below(vectors_.size())];
    std::size_t command = below(0x24);
    while (kLengths[command].request < 0) command = below(0x24);
    Bytes payload(static_cast<std::size_t>(kLengths[command].request));
    for (std::uint8_t& each : payload)
      each = below(3) == 0 ? byte() : static_cast<std::uint8_t>(below(4));
    return telegram(static_cast<std::uint8_t>(command), payload);
  }

  RandomStream random_;
  std::vector<Bytes> vectors_;
};

class HostileFrames : public testing::Test {
 protected:
  HostileFrames() {
    bench_.line().on_host_byte([this](std::uint8_t byte, SimTime) { heard_.push_back(byte); });
  }

  // To the drive and to the model, at one instant; then 10 us pass, so that motors that were
  // started turn.
  void send(std::span<const std::uint8_t> bytes) {
    model_.hear(bytes);
    bench_.line().host_send(bytes);
    bench_.run_for(10us);
  }

  // Takes the answers that the model announces off what the drive said; what is wrong, if anything.
  std::string check_answers() {
    std::size_t at = 0;
    for (; !model_.answers.empty(); model_.answers.pop_front()) {
      const Expected expected = model_.answers.front();
      const auto rest = std::span(heard_).subspan(at);
      if (rest.size() < 2) return fmt::format("no answer to {:02x}", expected.command);
      const bool error = rest[1] == kError;
      if (rest[0] != kBot || (!error && rest[1] != expected.command))
        return "no answer's beginning";
      const auto payload = static_cast<std::size_t>(error ? 1 : kLengths[expected.command].reply);
      if (rest.size() < payload + 4) return "an answer cut short";
      if (crc8(rest.subspan(1, payload + 1)) != rest[payload + 2]) return "a wrong CRC";
      if (rest[payload + 3] != kEot) return "a wrong end";
      if (expected.crc_error != (error && rest[2] == kCrcError)) return "a CRC error mistaken";
      at += payload + 4;
    }
    const std::size_t extra = heard_.size() - at;
    heard_.clear();
    return extra == 0 ? "" : fmt::format("{} bytes too many", extra);
  }

  std::string burst(Hostile& hostile) {
    for (std::size_t n = 1 + hostile.below(16); n > 0; --n) {
      Bytes bytes = hostile.frame();
      ++frames_;
      // Now and then in two pieces, or with the next one at its heels: the drive is deaf by then.
      const std::size_t cut = hostile.below(4) == 0 ? hostile.below(bytes.size() + 1) : 0;
      send(std::span(bytes).first(cut));
      bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(cut));
      if (hostile.below(8) == 0) {
        const Bytes next = hostile.frame();
        bytes.insert(bytes.end(), next.begin(), next.end());
        ++frames_;
      }
      send(bytes);
      const std::string wrong = check_answers();
      if (!wrong.empty()) return fmt::format("{} to {:02x}", wrong, fmt::join(bytes, " "));
    }
    return "";
  }

  // A good request as the drive takes it: swallowed while a telegram is under way, then answered.
  std::string good_request() {
    static constexpr std::uint8_t kVersion[] = {0x11, 0x14, 0x00, 0x6c, 0x13};
    static const Bytes kAnswer = {0x11, 0x14, 0x03, 0x0a, 0x0a, 0x13};
    for (int attempt = 0; attempt < 64; ++attempt) {
      const bool idle = model_.idle();
      send(kVersion);
      if (idle && heard_ != kAnswer) {
        return fmt::format("the good request got {:02x}", fmt::join(heard_, " "));
      }
      const std::string wrong = check_answers();
      if (!wrong.empty() || idle) return wrong;
      // What the telegram under way still lacks: noughts end it, whatever it is.
      if (!model_.idle() && attempt > 12) send(std::array<std::uint8_t, 1>{0});
      heard_.clear();
      model_.answers.clear();
    }
    return "never idle again";
  }

  Bench bench_{{.drives = {{.kind = "toshiba-mcu"}},
                .lines = {{.timing = LineTiming::kIdeal}},
                .integrator = Integrator::kFast}};
  Receiver model_;
  Bytes heard_;
  std::uint64_t frames_ = 0;
};

TEST_F(HostileFrames, AreAnsweredAsTheDocumentSaysAndAGoodRequestAfterEachBurst) {
  Hostile hostile(Seed{1}.stream("hostile frames"));
  ASSERT_TRUE(hostile.has_vectors());
  std::uint64_t bursts = 0;
  for (; frames_ < kFrames; ++bursts) {
    std::string wrong = burst(hostile);
    if (wrong.empty()) wrong = good_request();
    ASSERT_EQ(wrong, "") << "burst " << bursts << ", frame " << frames_;
  }
  const WireCounters counters = bench_.drive().controller().wire_counters();
  EXPECT_GT(counters.requests, frames_ / 10);
  EXPECT_GT(counters.bad_frames, frames_ / 10);
  EXPECT_GT(counters.bytes_lost, frames_ / 100);
  std::printf("%llu frames in %llu bursts, %llu requests taken\n",
              static_cast<unsigned long long>(frames_), static_cast<unsigned long long>(bursts),
              static_cast<unsigned long long>(counters.requests));
}

}  // namespace
}  // namespace virtdrive
