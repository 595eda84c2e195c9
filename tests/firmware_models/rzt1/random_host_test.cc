// A host that orders anything at any time.
#include <cmath>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/firmware_models/rzt1/rig.h"

namespace virtdrive::rzt1 {
namespace {

using namespace std::chrono_literals;

std::int32_t any_value(RandomStream& random) {
  const auto bits = static_cast<std::uint32_t>(random.bits());
  switch (random.bits() % 5) {
    case 0:
      return static_cast<std::int32_t>(bits % 8);
    case 1:
      return static_cast<std::int16_t>(bits);
    case 2:
      return static_cast<std::uint16_t>(bits);
    case 3:
      return bits % 2 == 0 ? INT32_MIN : INT32_MAX;
    default:
      return static_cast<std::int32_t>(bits);
  }
}

void any_order(ServoDrive& drive, Hardware& hardware, RandomStream& random) {
  ServoAxis& axis = drive.axis(random.bits() % 2);
  const std::int32_t value = any_value(random);
  const auto parameters = saved_settings();
  switch (random.bits() % 28) {
    case 0:
      return void(axis.on());
    case 1:
      return void(axis.off());
    case 2:
      return void(axis.enable());
    case 3:
      return void(axis.disable());
    case 4:
      return void(axis.go());
    case 5:
      return void(axis.stop());
    case 6:
      return void(axis.abort());
    case 7:
      return void(axis.home());
    case 8:
      return void(axis.align());
    case 9:
      return void(axis.setup());
    case 10:
      return void(axis.forward());
    case 11:
      return void(axis.reverse());
    case 12:
      return void(axis.jog(value));
    case 13:
      return void(axis.follow(value, value % 50));
    case 14:
      return axis.set_target(value);
    case 15:
      return axis.set_distance(value);
    case 16:
      return void(axis.init_pvt(value % 300));
    case 17:
      return void(axis.push_pvt_velocity(value));
    case 18:
      return axis.set_pvt_position(value);
    case 19:
      return void(axis.set_position(value));
    case 20:
      return void(axis.set_output(value % 40'000));
    case 21:
      return void(axis.set_phase_output(random.bits() % 3, value));
    case 22:
      return void(drive.set_trigger(value % 12));
    case 23:
      hardware.axis[axis.number()].input_pins = static_cast<std::uint8_t>(value);
      return drive.hardware_changed();
    case 24:
      return axis.reset_errors();
    case 25:
      return void(axis.restore(axis.saved()));
    default:
      return void(axis.set(parameters[random.bits() % parameters.size()].member, value));
  }
}

TEST(RandomHost, LeavesTheServoWithinItsBounds) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    RandomStream random(seed);
    Rig rig;
    for (int i = 0; i < 400; ++i) {
      any_order(*rig.drive, rig.hardware, random);
      rig.run_for(SimDuration(random.bits() % 2'000'000));
      for (const std::size_t axis : {0U, 1U}) {
        ASSERT_TRUE(std::isfinite(rig.angle_rad(axis)));
        for (std::size_t phase = 0; phase < 3; ++phase) {
          const std::int32_t duty = rig.axis(axis).phase_output(phase);
          ASSERT_GE(duty, 0);
          ASSERT_LE(duty, 32767);
        }
      }
      if (random.bits() % 100 == 0) {
        rig.drive->restart({rig.axis(0).saved(), rig.axis(1).saved()});
      }
    }
    // After a reset with the factory's settings it works as ever.
    rig.hardware = Hardware{};
    rig.change_load({}, 0);
    rig.drive->restart({factory_settings(1), factory_settings(2)});
    rig.run_to([&] { return rig.plant().state().speed_radps == 0; }, 20);
    ASSERT_EQ(rig.ready(), Result::kOk);
    rig.move_to(rig.axis().position() + 20'000);
    rig.run_for(100ms);
    EXPECT_NEAR(rig.axis().position_error(), 0, 5);
  }
}

}  // namespace
}  // namespace virtdrive::rzt1
