#include "core/signals.h"

#include <gtest/gtest.h>

#include "core/check.h"

namespace virtdrive {
namespace {

Registry registry_with_load(double* torque) {
  Registry registry;
  registry.add(Signal{"motor0.speed", "rpm", "Rotor speed", [] { return 2000.0; }});
  registry.add(
      Input{{"load0.brake_torque", "Nm", "Torque against the motion", [=] { return *torque; }},
            0,
            1,
            [=](double value) { *torque = value; }});
  return registry;
}

TEST(Registry, ReadsSignalsAndInputsByName) {
  double torque = 0.25;
  const Registry registry = registry_with_load(&torque);
  EXPECT_EQ(registry.signal("motor0.speed").read(), 2000.0);
  EXPECT_EQ(registry.signal("load0.brake_torque").read(), 0.25);
}

TEST(Registry, WritesAnInputWithinItsRange) {
  double torque = 0;
  const Registry registry = registry_with_load(&torque);
  registry.set("load0.brake_torque", 0.5);
  EXPECT_EQ(torque, 0.5);
  EXPECT_THROW(registry.set("load0.brake_torque", 2), SetupError);
  EXPECT_THROW(registry.set("load0.brake_torque", std::numeric_limits<double>::quiet_NaN()),
               SetupError);
  EXPECT_EQ(torque, 0.5);
}

TEST(Registry, AFaultIsThereOrNot) {
  double open = 0, lost = 0, torque = 0;
  Registry registry = registry_with_load(&torque);
  const auto add = [&](const char* name, double* value) {
    registry.add(Input{.signal = {name, "", "", [=] { return *value; }},
                       .minimum = 0,
                       .maximum = 1,
                       .write = [=](double v) { *value = v; },
                       .fault = true});
  };
  add("motor0.phase_a_open", &open);
  add("line.lost", &lost);
  registry.inject("motor0.phase_a_open");
  registry.inject("line.lost", 0.25);
  EXPECT_EQ(open, 1);
  EXPECT_EQ(lost, 0.25);
  EXPECT_THROW(registry.inject("line.lost", 2), SetupError);
  registry.clear("motor0.phase_a_open");
  EXPECT_EQ(open, 0);
  torque = 0.5;
  EXPECT_THROW(registry.inject("load0.brake_torque", 0.5), SetupError);  // an input, no fault
  registry.clear_faults();
  EXPECT_EQ(lost, 0);
  EXPECT_EQ(torque, 0.5);
}

TEST(Registry, AScopeGoesBeforeTheNames) {
  double torque = 0;
  Registry registry;
  registry.set_scope("left");
  registry.add(Signal{"motor0.speed", "rpm", "Rotor speed", [] { return 1.0; }});
  registry.add(
      Input{{"load0.inertia", "kgm2", "", [&] { return torque; }}, 0, 1, [&](double value) {
              torque = value;
            }});
  registry.set_scope("");
  registry.add(Signal{"motor0.speed", "rpm", "Rotor speed", [] { return 2.0; }});
  EXPECT_EQ(registry.signal("left.motor0.speed").read(), 1.0);
  EXPECT_EQ(registry.signal("motor0.speed").read(), 2.0);
  registry.set("left.load0.inertia", 0.5);
  EXPECT_EQ(registry.signal("left.load0.inertia").read(), 0.5);
}

TEST(Registry, AnUnknownNameIsAClearError) {
  double torque = 0;
  const Registry registry = registry_with_load(&torque);
  try {
    registry.signal("motor0.sped");
    FAIL();
  } catch (const SetupError& error) {
    EXPECT_NE(std::string(error.what()).find("did you mean motor0.speed"), std::string::npos);
  }
  EXPECT_THROW(registry.set("motor0.speed", 1), SetupError);  // a signal is not an input
}

}  // namespace
}  // namespace virtdrive
