#include "devices/framers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tuple>

#include "core/check.h"
#include "tests/devices/vectors.h"

namespace virtdrive {
namespace {

using protocol::Direction;
using protocol::Verdict;
using Runs = std::vector<protocol::Run>;

constexpr Direction kRequest = Direction::kRequest;
constexpr Direction kReply = Direction::kReply;

// A run as a test writes it: how many bytes, what they are.
struct Shown {
  std::size_t size;
  Verdict verdict;
  friend bool operator==(const Shown&, const Shown&) = default;
  friend std::ostream& operator<<(std::ostream& out, const Shown& run) {
    return out << run.size << " bytes: " << static_cast<int>(run.verdict);
  }
};

class Analyser {
 public:
  explicit Analyser(std::string_view protocol) : framer_(make_framer(protocol)) {}

  Runs hear(Direction direction, const std::string& hex) {
    Runs runs;
    for (const std::uint8_t byte : from_hex(hex)) framer_->push(direction, byte, runs);
    return runs;
  }
  Runs expire(Direction direction) {
    Runs runs;
    framer_->expire(direction, runs);
    return runs;
  }
  SimDuration silence() const { return framer_->silence(); }

 private:
  std::unique_ptr<protocol::Framer> framer_;
};

std::vector<Shown> shown(const Runs& runs) {
  std::vector<Shown> shown;
  for (const auto& run : runs) shown.push_back({run.size, run.verdict});
  return shown;
}

std::size_t bytes_in(const Runs& runs) {
  std::size_t bytes = 0;
  for (const auto& run : runs) bytes += run.size;
  return bytes;
}

std::string text(const Runs& runs) {
  return runs.empty() ? "nothing" : runs.back().text;
}

TEST(Framers, AreThereForEachProtocolThatHasACodec) {
  for (const char* protocol : {"toshiba-mcu", "md485", "rzt1", "asd7", "bytes"}) {
    EXPECT_NE(make_framer(protocol), nullptr) << protocol;
  }
  EXPECT_DEATH(make_framer("modbus"), "no framer of protocol 'modbus'");
}

TEST(Framers, ToshibaTelegramsNoiseAndWhatIsWrong) {
  Analyser analyser("toshiba-mcu");
  EXPECT_EQ(shown(analyser.hear(kRequest, "55 11 14 00 6c 13")),
            (std::vector<Shown>{{1, Verdict::kNoise}, {5, Verdict::kFrame}}));
  const auto reply = analyser.hear(kReply, "11 14 03 0a 0a 13");
  EXPECT_EQ(shown(reply), (std::vector<Shown>{{6, Verdict::kFrame}}));
  EXPECT_EQ(text(reply), "GetFWVersion major=3 minor=10");
  EXPECT_EQ(text(analyser.hear(kReply, "11 ee ff 77 13")), "Error code=-1");
  EXPECT_EQ(shown(analyser.hear(kRequest, "11 00 01 06 13")),
            (std::vector<Shown>{{5, Verdict::kBadChecksum}}));
  EXPECT_EQ(shown(analyser.hear(kRequest, "11 14 00 6c 14")),
            (std::vector<Shown>{{5, Verdict::kMalformed}}));
  EXPECT_EQ(shown(analyser.hear(kRequest, "11 99")),
            (std::vector<Shown>{{2, Verdict::kMalformed}}));
}

TEST(Framers, AToshibaTelegramWaitsForEverForItsRest) {
  Analyser analyser("toshiba-mcu");
  EXPECT_EQ(analyser.silence(), SimDuration{});
  EXPECT_EQ(text(analyser.hear(kRequest, "11 14 00")), "nothing");
  EXPECT_EQ(shown(analyser.expire(kRequest)), (std::vector<Shown>{{3, Verdict::kCutShort}}));
  EXPECT_TRUE(analyser.expire(kRequest).empty());
  EXPECT_TRUE(analyser.expire(kReply).empty());
}

TEST(Framers, Md485FramesBehindFalseOnes) {
  Analyser analyser("md485");
  EXPECT_EQ(analyser.silence(), std::chrono::milliseconds(10));
  const std::string whole = "b7 ac 01 04 01 c1 d6";  // asks for PID 193
  EXPECT_EQ(shown(analyser.hear(kRequest, "01 02 " + whole)),
            (std::vector<Shown>{{1, Verdict::kNoise}, {1, Verdict::kNoise}, {7, Verdict::kFrame}}));
  EXPECT_EQ(text(analyser.hear(kRequest, whole)).substr(0, 4), "PID_");
  // A false frame of no data takes the true one's first bytes; its sum tells.
  Runs runs = analyser.hear(kRequest, "b7 00 00 00 00 55 " + whole);
  EXPECT_EQ(bytes_in(runs), 13U);
  EXPECT_EQ(shown({runs.back()}), (std::vector<Shown>{{7, Verdict::kFrame}}));
  // Cut short: given up after silence, with a frame behind it found.
  EXPECT_TRUE(analyser.hear(kRequest, "b7 ac 01 04 7f " + whole).empty());
  runs = analyser.expire(kRequest);
  EXPECT_EQ(runs.back().verdict, Verdict::kFrame);
}

TEST(Framers, Asd7MessagesInAllFormats) {
  Analyser analyser("asd7");
  // A start inside of a message begins another.
  EXPECT_EQ(shown(analyser.hear(kRequest, "28 52 28")),
            (std::vector<Shown>{{2, Verdict::kMalformed}}));
  EXPECT_EQ(shown(analyser.expire(kRequest)), (std::vector<Shown>{{1, Verdict::kCutShort}}));
}

TEST(Framers, Rzt1RepliesAreFramedByWhatWasAsked) {
  Analyser analyser("rzt1");
  EXPECT_EQ(shown(analyser.hear(kReply, "00")), (std::vector<Shown>{{1, Verdict::kNoise}}));
  // Line: "1POS?" is refused or not, the framer knows the prompt's end.
  const auto line = analyser.hear(kRequest, "31 58 58 58 0d");
  EXPECT_EQ(shown(line), (std::vector<Shown>{{5, Verdict::kMalformed}}));
  EXPECT_EQ(text(line), "1XXX");
  EXPECT_EQ(text(analyser.hear(kReply, "0d 0a 3f")), "refused");
  EXPECT_EQ(text(analyser.hear(kReply, "0d 0a 3e")), "accepted");
  // A packet with a wrong sum gets status 255 and nothing else.
  EXPECT_EQ(shown(analyser.hear(kRequest, "aa 01 00 00 77")),
            (std::vector<Shown>{{5, Verdict::kBadChecksum}}));
  EXPECT_EQ(text(analyser.hear(kReply, "ff ff")), "status=255");
  EXPECT_EQ(shown(analyser.hear(kReply, "00")), (std::vector<Shown>{{1, Verdict::kNoise}}));
}

// The decoders' own tests say what the frames of the documents hold. RZ/T1 replies alone say
// nothing.
TEST(Framers, TheDocumentsFramesAreARunEachAndNoByteIsLost) {
  for (const auto& [protocol, file, most] :
       {std::tuple("toshiba-mcu", "vectors_toshiba_mcu.csv", 80),
        std::tuple("md485", "vectors_md485.csv", 10), std::tuple("asd7", "vectors_asd7.csv", 60),
        std::tuple("rzt1", "vectors_rzt1.csv", 20)}) {
    int whole = 0;
    for (const Vector& vector : read_vectors(file)) {
      Analyser analyser(protocol);
      const Direction direction = vector.direction == "request" ? kRequest : kReply;
      std::string hex;
      for (const std::uint8_t byte : vector.bytes) hex += fmt::format("{:02x} ", byte);
      const Runs runs = analyser.hear(direction, hex);
      EXPECT_EQ(bytes_in(runs) + bytes_in(analyser.expire(direction)), vector.bytes.size())
          << vector.name;
      if (runs.size() == 1 && runs[0].verdict == Verdict::kFrame) ++whole;
    }
    EXPECT_GE(whole, most) << protocol;
  }
}

}  // namespace
}  // namespace virtdrive
