// Ten thousand hosts, one after another: what each left unread is gone, and nothing grows.
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/pty/pumped_endpoint.h"

namespace virtdrive {
namespace {

using Bytes = std::vector<std::uint8_t>;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr std::int64_t kMostGrowth = std::int64_t{1} << 40;  // they keep what was freed
#else
constexpr std::int64_t kMostGrowth = 512 * 1024;  // what an allocator may still take
#endif

std::size_t open_descriptors() {
  const std::filesystem::directory_iterator entries("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(entries), end(entries)));
}

/// Bytes, of proc(5)'s statm.
std::int64_t resident() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t size = 0;
  std::int64_t pages = 0;
  statm >> size >> pages;
  return pages * sysconf(_SC_PAGESIZE);
}

FileDescriptor open_host(const PumpedEndpoint& bench) {
  return FileDescriptor{
      ::open(bench.endpoint.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
}

TEST(PtyEndurance, TenThousandHostsFindNothingStaleAndLeaveNothingBehind) {
  constexpr int kCycles = 10'000;
  constexpr int kWarmUp = 500;
  PumpedEndpoint bench;
  std::size_t descriptors = 0;
  std::int64_t memory = 0;
  for (int cycle = 0; cycle < kWarmUp + kCycles; ++cycle) {
    if (cycle == kWarmUp) {
      descriptors = open_descriptors();
      memory = resident();
    }
    const auto mark = static_cast<std::uint8_t>(cycle);
    FileDescriptor host = open_host(bench);
    ASSERT_TRUE(bench.pump([&] { return bench.endpoint.attached(); }));
    ASSERT_FALSE(bench.readable_now(host.get())) << "stale bytes in cycle " << cycle;

    bench.heard.clear();
    ASSERT_EQ(::write(host.get(), &mark, 1), 1);
    ASSERT_TRUE(bench.pump([&] { return !bench.heard.empty(); }));
    ASSERT_EQ(bench.heard, Bytes{mark});
    bench.say({mark, 2, 3, 4});
    ASSERT_TRUE(PumpedEndpoint::readable(host.get()));
    if (cycle % 2 == 0) {  // the others leave it for the next one to find
      Bytes answer(16);
      ASSERT_EQ(::read(host.get(), answer.data(), answer.size()), 4);
      ASSERT_EQ(answer[0], mark);
    }
    host.reset();
    ASSERT_TRUE(bench.pump([&] { return !bench.endpoint.attached(); }));
  }
  EXPECT_EQ(open_descriptors(), descriptors);
  EXPECT_LT(resident() - memory, kMostGrowth);
  EXPECT_EQ(bench.endpoint.counters().attached, kWarmUp + kCycles);
}

TEST(PtyEndurance, AHostThatNeverReadsCostsNoMemoryAndNoTime) {
  PumpedEndpoint bench({.baud = 1'000'000});
  const FileDescriptor host = open_host(bench);
  ASSERT_TRUE(bench.pump([&] { return bench.endpoint.attached(); }));
  const Bytes block(1000, 0x55);
  std::int64_t memory = 0;
  for (int i = 0; i < 10'000; ++i) {  // 10 MB
    if (i == 1000) memory = resident();
    bench.say(block);
  }
  EXPECT_LT(resident() - memory, kMostGrowth);
  EXPECT_EQ(bench.loop.now(), kSimStart + std::chrono::seconds{100});
  EXPECT_GT(bench.endpoint.counters().overrun, 9'900'000U);
}

}  // namespace
}  // namespace virtdrive
