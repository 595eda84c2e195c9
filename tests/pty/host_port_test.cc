#include "pty/host_port.h"

#include <gtest/gtest.h>

#include "core/check.h"
#include "pty/pty_endpoint.h"
#include "tests/pty/pumped_endpoint.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

TEST(HostPort, WritesAndReadsThroughAnEndpoint) {
  PumpedEndpoint bench;
  HostPort host{bench.endpoint.path(), 115200};
  host.write(Bytes{1, 2, 3});
  ASSERT_TRUE(bench.pump([&] { return bench.heard.size() == 3; }));
  bench.say({9, 8});
  EXPECT_EQ(host.read(2, 5s), (Bytes{9, 8}));
}

TEST(HostPort, ReturnsWhatHasComeWhenTheTimeIsOver) {
  PumpedEndpoint bench;
  HostPort host{bench.endpoint.path(), 115200};
  ASSERT_TRUE(bench.pump([&] { return bench.endpoint.attached(); }));
  bench.say({7});
  ASSERT_TRUE(bench.readable(host.fd()));
  EXPECT_EQ(host.read(2, 1ms), (Bytes{7}));
  EXPECT_EQ(host.read(SimDuration{1}), std::nullopt);
}

TEST(HostPort, SaysThatAPortIsNotThereOrIsNone) {
  EXPECT_THROW(HostPort("/nowhere/drive", 115200), SetupError);
  EXPECT_THROW(HostPort("/dev/null", 115200), SetupError);
}

TEST(HostPort, SaysThatThePortIsGone) {
  std::optional<PumpedEndpoint> bench{std::in_place};
  HostPort host{bench->endpoint.path(), 115200};
  bench.reset();
  EXPECT_THROW(host.read(1, 5s), SetupError);
  EXPECT_THROW(host.write(Bytes{1}), SetupError);
}

}  // namespace
}  // namespace virtdrive
