#include "scenarios/memory_faults.h"

#include <gtest/gtest.h>

#include "scenarios/bench.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

const std::vector<std::uint8_t> kOld = {1, 2, 3, 4}, kNew = {5, 6, 7, 8};

struct MemoryRig {
  EventLoop loop;
  FaultyMemory memory{std::make_unique<MemoryInProcess>(), loop, Seed(1)};
  Registry registry;
  MemoryRig() { memory.register_signals(registry); }
};

TEST(FaultyMemory, WornBitsAreTheSameEachTimeAndGoneWhenTheFaultIs) {
  MemoryRig rig;
  rig.memory.write("block", kOld);
  rig.registry.inject("memory.worn_bits", 1);
  const auto worn = rig.memory.read("block");
  EXPECT_NE(worn, kOld);
  EXPECT_EQ(rig.memory.read("block"), worn);
  rig.registry.clear("memory.worn_bits");
  EXPECT_EQ(rig.memory.read("block"), kOld);
}

TEST(FaultyMemory, ALockedOneKeepsWhatItHas) {
  MemoryRig rig;
  rig.memory.write("block", kOld);
  rig.registry.inject("memory.locked");
  EXPECT_FALSE(rig.memory.write("block", kNew));
  EXPECT_FALSE(rig.memory.erase());
  EXPECT_EQ(rig.memory.read("block"), kOld);
}

TEST(FaultyMemory, PowerThatGoesInTheMiddleOfAWriteLeavesItTorn) {
  MemoryRig rig;
  rig.memory.write("block", kOld);
  rig.registry.set("memory.write_time", 0.020);
  rig.memory.write("block", kNew);
  rig.memory.write("other", kNew);
  rig.loop.run_until(kSimStart + 10ms);
  rig.memory.power_lost();
  EXPECT_EQ(rig.memory.read("block"), (std::vector<std::uint8_t>{5, 6, 3, 4}));
  EXPECT_EQ(rig.memory.read("other"), (std::vector<std::uint8_t>{5, 6, 0xFF, 0xFF}));
}

TEST(FaultyMemory, AWriteThatWasThroughIsWhole) {
  MemoryRig rig;
  rig.registry.set("memory.write_time", 0.020);
  rig.memory.write("block", kNew);
  rig.loop.run_until(kSimStart + 20ms);
  rig.memory.power_lost();
  EXPECT_EQ(rig.memory.read("block"), kNew);
}

// Both drives keep a checksum: what is damaged is not believed.
TEST(FaultyMemory, DrivesStartWithTheirFactorySettingsWhenWhatTheyStoredIsDamaged) {
  Bench bench({.drives = {{.kind = "toshiba-mcu"}}});
  const auto host = bench.host();
  host->set("MaxAngAcc=411");
  host->call("StoreParameters", {1});
  bench.drive().reset();
  bench.run_for(1s);
  EXPECT_EQ(host->get("MaxAngAcc").value, 411);
  bench.registry().inject("memory.worn_bits", 1);
  bench.drive().reset();
  bench.run_for(1s);
  EXPECT_EQ(host->get("MaxAngAcc").value, 300);
}

}  // namespace
}  // namespace virtdrive
