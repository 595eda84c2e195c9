#include "firmware_models/asd7/ac_drive.h"

#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "plant/pump.h"
#include "tests/firmware_models/asd7/drive_bench.h"

namespace virtdrive::asd7 {
namespace {

std::string trip_of(const DriveBench& b) {
  return std::string(trip_name(b.drive.trip()));
}

// --- Status and ramps ----------------------------------------------------------------------------

TEST(Asd7Drive, StatusWordsAreThoseOfTheFamily) {
  DriveBench b("0.75");
  b.run(10ms);
  EXPECT_TRUE(b.drive.alive());
  EXPECT_EQ(b.status(), 0x4000);
  b.start(20);
  b.run(100ms);
  EXPECT_EQ(b.status(), 0x6400);
  b.stop();
  b.run(100ms);
  EXPECT_EQ(b.status(), 0x4400) << "slows down";
  b.run(3s);
  EXPECT_EQ(b.status(), 0x4000);
  b.drive.set_command(0xc600);
  b.run(1s);
  EXPECT_EQ(b.status(), 0x6600);
  EXPECT_LT(b.rpm(), 0);
  b.drive.set_command(0xcc00);
  b.run(10ms);
  EXPECT_EQ(b.status(), 0x4800) << "coasts";
  EXPECT_EQ(b.hz(), 0);
  b.drive.set_command(0xc500);
  b.run(2s);
  EXPECT_EQ(b.status(), 0x6500);
  EXPECT_EQ(b.hz(), 5) << "jog";
}

TEST(Asd7Drive, TheOutputMovesExactlyOnTheRamp) {
  DriveBench b("0.75");
  b.start(40);
  b.run(2ms + 3s);
  EXPECT_NEAR(b.hz(), 0.5 + 3 * 8, 0.02);
  b.run(2s);
  EXPECT_EQ(b.hz(), 40);
  EXPECT_NEAR(b.rpm(), 40 * 30, 20);
  b.drive.set_command(0xc440);  // second ramp
  b.set([](Settings& s) { s.deceleration2 = 20; });
  b.drive.set_frequency(1000);
  b.run(500ms);
  EXPECT_NEAR(b.hz(), 40 - 0.5 * 40, 0.1);
}

TEST(Asd7Drive, ReversesThroughItsStartFrequency) {
  DriveBench b("0.75");
  b.start(10);
  b.run(2s);
  b.drive.set_command(0xc600);
  double least = 10;
  for (int i = 0; i < 200; ++i) {
    b.run(10ms);
    least = std::min(least, b.hz());
    ASSERT_NE(b.status() & kStatusRunning, 0);
  }
  EXPECT_LT(least, 0.7);
  b.run(1s);
  EXPECT_EQ(b.hz(), 10);
  EXPECT_TRUE(b.drive.monitor().reverse);
  EXPECT_NEAR(b.rpm(), -300, 10);
}

// --- Loads ---------------------------------------------------------------------------------------

class Asd7Sizes : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(All, Asd7Sizes, testing::Values("0.75", "4", "22"),
                         [](const testing::TestParamInfo<const char*>& p) {
                           return std::string(p.param) == "0.75" ? "Smallest"
                                                                 : "Of" + std::string(p.param);
                         });

TEST_P(Asd7Sizes, ReachSixtyHertzWithAFan) {
  DriveBench b(GetParam());
  b.load(b.fan());
  b.start(60);
  b.until_trip(b.run_up() + 1s);
  EXPECT_FALSE(b.drive.tripped()) << trip_of(b);
  EXPECT_EQ(b.hz(), 60);
  EXPECT_NEAR(b.rpm() / b.motor.rating.speed_rpm, 1, 0.006);
  EXPECT_NEAR(b.drive.monitor().torque / 1e4, 1, 0.09) << "as the drive estimates it";
}

TEST_P(Asd7Sizes, ReachSixtyHertzAgainstConstantTorque) {
  DriveBench b(GetParam());
  b.load({.inertia_kgm2 = b.motor.mechanics.inertia_kgm2, .brake_torque_nm = 1.2 * b.rated_nm()});
  b.start(60);
  // Rms over 10 ms, in percent of the rated current.
  double peak = 0;
  for (int i = 0; i < b.run_up() / 10ms && !b.drive.tripped(); ++i) {
    double squares = 0;
    for (int k = 0; k < 10; ++k) {
      b.run(1ms);
      const AxisState& x = b.axis.state();
      squares += (x.i_d_a * x.i_d_a + x.i_q_a * x.i_q_a) / 2;
    }
    peak = std::max(peak, 100 * std::sqrt(squares / 10) / b.model.rated_current_a);
  }
  EXPECT_FALSE(b.drive.tripped()) << trip_of(b);
  EXPECT_EQ(b.hz(), 60);
  const double expected = b.model.name == "0.75" ? 96 : b.model.name == "4" ? 126 : 154;
  EXPECT_NEAR(peak / expected, 1, 0.1);
}

TEST_P(Asd7Sizes, StopFiveTimesTheInertiaWithoutResistorOrTrip) {
  DriveBench b(GetParam());
  b.load({.inertia_kgm2 = 4 * b.motor.mechanics.inertia_kgm2});
  b.start(60);
  b.run(b.run_up());
  ASSERT_EQ(b.hz(), 60);
  b.stop();
  b.until_trip(b.run_up() + 4s);
  EXPECT_FALSE(b.drive.tripped()) << trip_of(b);
  EXPECT_EQ(b.status(), 0x4000);
}

TEST_P(Asd7Sizes, TooFastADecelerationTripsWithoutResistorAndNotWithIt) {
  for (const bool resistor : {false, true}) {
    SCOPED_TRACE(resistor);
    DriveBench b(GetParam());
    b.set([&](Settings& s) {
      s.braking_resistor = resistor ? 1 : 0;
      s.overvoltage_limit = 1;  // off
    });
    b.load({.inertia_kgm2 = 4 * b.motor.mechanics.inertia_kgm2});
    b.start(60);
    b.run(b.run_up());
    ASSERT_EQ(b.hz(), 60);
    b.set([](Settings& s) { s.deceleration1 = 13; });
    b.stop();
    if (resistor) {
      b.until_trip(1500ms);
      EXPECT_FALSE(b.drive.tripped()) << trip_of(b);
      EXPECT_EQ(b.status(), 0x4000);
    } else {
      EXPECT_LT(b.until_trip(1500ms), 1);
      EXPECT_EQ(b.drive.trip(), Trip::kOp2);
      EXPECT_GT(b.drive.bus_v(), 0.99 * b.model.link.trip_v);
    }
  }
}

TEST(Asd7Drive, TheLargestTripsWhereItsLimitIsTooSlow) {
  DriveBench b("22");
  b.load({.inertia_kgm2 = 4 * b.motor.mechanics.inertia_kgm2});
  b.start(60);
  b.run(24s);
  ASSERT_EQ(b.hz(), 60);
  b.set([](Settings& s) { s.deceleration1 = 27; });  // 30 Hz/s
  b.stop();
  EXPECT_LT(b.until_trip(5s), 5);
  EXPECT_EQ(b.drive.trip(), Trip::kOp2);
}

TEST(Asd7Drive, TheOvervoltageLimitHoldsTheLinkOfTheSmallest) {
  DriveBench b("0.75");
  b.load({.inertia_kgm2 = 4 * b.motor.mechanics.inertia_kgm2});
  b.start(60);
  b.run(10s);
  b.set([](Settings& s) { s.deceleration1 = 27; });  // 30 Hz/s
  b.stop();
  b.until_trip(8s);
  EXPECT_FALSE(b.drive.tripped()) << trip_of(b);
  EXPECT_EQ(b.status(), 0x4000);
}

// A hoist's load pulls one way: the mechanical brake holds it until the drive has its torque.
TEST(Asd7Drive, AHoistLiftsAndLowersItsLoadIntoTheResistor) {
  DriveBench b("0.75");
  b.set([](Settings& s) {
    s.braking_resistor = 1;
    s.torque_boost1 = 80;
  });
  const double inertia = b.motor.mechanics.inertia_kgm2;
  const Load held{.inertia_kgm2 = inertia,
                  .brake_torque_nm = 2 * b.rated_nm(),
                  .external_torque_nm = 0.6 * b.rated_nm()};
  const Load hanging{.inertia_kgm2 = inertia, .external_torque_nm = 0.6 * b.rated_nm()};
  b.load(held);
  b.run(100ms);
  EXPECT_EQ(b.rpm(), 0);
  b.start(30);
  b.run(300ms);
  EXPECT_EQ(b.rpm(), 0) << "the brake holds";
  b.load(hanging);
  b.run(6s);
  ASSERT_FALSE(b.drive.tripped()) << trip_of(b);
  EXPECT_NEAR(b.rpm(), 860, 30);
  EXPECT_GT(b.drive.monitor().torque, 4000);
  b.drive.set_command(0xc600);  // lower
  b.run(10s);
  ASSERT_FALSE(b.drive.tripped()) << trip_of(b);
  EXPECT_LT(b.rpm(), -900) << "beyond synchronism";
  EXPECT_GT(b.axis.bus().chopper_degc(), 30);
  EXPECT_GT(b.drive.monitor().torque, 2000) << "still up";
  b.drive.set_command(0xd600);
  b.load(held);
  b.run(1s);
  EXPECT_EQ(b.drive.trip(), Trip::kE);
  EXPECT_EQ(b.rpm(), 0) << "held by the brake";
}

TEST(Asd7Drive, APumpHoldsItsPressureByPiControl) {
  DriveBench b("0.75");
  b.load(b.fan());
  b.set([](Settings& s) {
    s.pi_control = 1;
    s.pi_proportional = 50;
    s.pi_integral = 40;
  });
  // A transducer of 0..8 bar on VIA, whose 0..100 % stand for 0..60 Hz: 30 Hz ask for 4 bar.
  Pump pump({.rated_radps = b.rated_radps(), .rated_bar = 6, .shutoff_bar = 8});
  const auto pumps = [&](SimDuration duration) {
    for (const SimTime end = b.loop.now() + duration; b.loop.now() < end;) {
      b.run(10ms);
      pump.advance_to(b.loop.now(), b.axis.state().speed_radps);
      Terminals pins;
      pins.via = static_cast<std::uint16_t>(std::lround(1e4 * pump.pressure_bar() / 8));
      b.drive.set_terminals(pins);
    }
  };
  b.start(30);
  pumps(20s);
  EXPECT_NEAR(pump.pressure_bar(), 4, 0.05);
  EXPECT_NEAR(b.drive.monitor().pi_feedback, 3000, 40);
  const double hz = b.hz();
  pump.set_demand(1.5);
  pumps(20s);
  EXPECT_NEAR(pump.pressure_bar(), 4, 0.05);
  EXPECT_GT(b.hz(), hz + 2) << "more consumers, more speed";
  b.drive.set_command(0xc420);  // PI off
  b.run(5s);
  EXPECT_EQ(b.hz(), 30);
}

TEST(Asd7Drive, SlipCompensationHoldsTheSpeed) {
  double rpm[2] = {};
  for (const int kind : {2, 3}) {
    DriveBench b("4");
    b.set([&](Settings& s) {
      s.volts_per_hertz = static_cast<std::uint16_t>(kind);
      s.slip_gain = 100;
    });
    b.load(b.fan(2, 2));
    b.start(40);
    b.run(10s);
    EXPECT_FALSE(b.drive.tripped()) << trip_of(b);
    rpm[kind - 2] = b.rpm();
  }
  EXPECT_LT(rpm[0], 1170);
  EXPECT_NEAR(rpm[1], 1200, 8);
}

TEST(Asd7Drive, DcBrakeHoldsAtTheEndOfAStop) {
  DriveBench b("0.75");
  b.set([](Settings& s) {
    s.dc_brake_frequency = 300;
    s.dc_brake_time = 20;
  });
  b.start(20);
  b.run(4s);
  b.stop();
  b.run(3500ms);
  EXPECT_EQ(b.status(), 0x4480);
  EXPECT_NEAR(b.current_percent(), 50, 3);
  EXPECT_EQ(b.hz(), 0);
  b.run(2s);
  EXPECT_EQ(b.status(), 0x4000);
  EXPECT_EQ(b.drive.trip(), Trip::kNone);
}

TEST(Asd7Drive, ForcedDcBrakeStandsAsLongAsItsBit) {
  DriveBench b("0.75");
  b.start(30);
  b.run(5s);
  b.drive.set_command(0xc480);
  b.run(3s);
  EXPECT_EQ(b.status() & kStatusDcBraking, kStatusDcBraking);
  EXPECT_NEAR(b.current_percent(), 50, 3);
  EXPECT_NEAR(b.rpm(), 0, 1);
  b.drive.set_command(0xc000);
  b.run(100ms);
  EXPECT_EQ(b.status(), 0x4000);
}

// --- Protections ---------------------------------------------------------------------------------

TEST(Asd7Drive, InverterOverloadTripsAtTheCurvesTime) {
  DriveBench b("0.75");
  b.set([](Settings& s) {
    s.stall_level1 = 200;
    s.motor_guard = 3;
  });
  b.load({.locked = true});
  b.start(15);
  b.run(3s);
  const double r = b.current_percent() / 100;
  ASSERT_GT(r, 1.15);
  ASSERT_LT(r, 1.75);
  const double level = b.drive.monitor().inverter_overload / 1e4;
  const double expected = (1 - level) * 60 * (1.5 * 1.5 - 1.21) / (r * r - 1.21);
  EXPECT_NEAR(b.until_trip(600s), expected, 0.02 * expected);
  EXPECT_EQ(b.drive.trip(), Trip::kOl1);
}

TEST(Asd7Drive, MotorOverloadTripsAtTheCurvesTimeAndKeepsItsIntegral) {
  DriveBench b("0.75");
  b.set([](Settings& s) {
    s.motor_protection1 = 60;
    s.motor_overload_time = 60;
  });
  b.load(b.fan());
  b.start(60);
  b.run(12s);
  const double r = b.drive.monitor().output_current / 1e4 * 4.8 / (0.6 * 3.0);
  ASSERT_GT(r, 1.3);
  const double level = b.drive.monitor().motor_overload / 1e4;
  const double expected = (1 - level) * 60 * (1.5 * 1.5 - 1.21) / (r * r - 1.21);
  EXPECT_NEAR(b.until_trip(300s), expected, 0.02 * expected);
  EXPECT_EQ(b.drive.trip(), Trip::kOl2);
  EXPECT_EQ(b.drive.set_command(kCommandReset), AcDrive::CommandResult::kIgnored) << "too hot";
  b.run(121s);
  EXPECT_LT(b.drive.monitor().motor_overload, 10000);
  EXPECT_EQ(b.drive.set_command(kCommandReset), AcDrive::CommandResult::kRestarts);
}

TEST(Asd7Drive, ABlockedStartIsHeldByTheStallLimitOrTrips) {
  DriveBench b("0.75");
  b.load({.locked = true});
  b.start(60);
  double most = 0;
  unsigned alarms = 0;
  for (int i = 0; i < 500 && !b.drive.tripped(); ++i) {
    b.run(10ms);
    most = std::max(most, b.current_percent());
    alarms |= b.drive.alarms();
  }
  EXPECT_FALSE(b.drive.tripped()) << trip_of(b);
  EXPECT_LT(most, 165);
  EXPECT_NE(alarms & kAlarmOverCurrent, 0U);
  EXPECT_LT(b.hz(), 20);
  b.set([](Settings& s) {
    s.stall_level1 = 200;
    s.acceleration1 = 1;
  });
  EXPECT_LT(b.until_trip(2s), 2);
  EXPECT_EQ(b.drive.trip(), Trip::kOc1);
  EXPECT_GT(b.drive.frozen().output_frequency, 0);
  EXPECT_EQ(b.drive.monitor().output_frequency, 0);
}

TEST(Asd7Drive, AMotorWireThatBreaksIsSeenAfterASecond) {
  DriveBench b("0.75");
  b.set([](Settings& s) { s.output_phase_guard = 1; });
  b.load(b.fan(0.5));
  b.start(40);
  b.run(8s);
  b.axis.advance_to(b.loop.now());
  b.axis.set_bridge_faults({.phase_open = {false, true, false}});
  EXPECT_NEAR(b.until_trip(3s), 1.0, 0.35);
  EXPECT_EQ(b.drive.trip(), Trip::kEpho);
}

TEST(Asd7Drive, ALostSupplyPhaseTripsUnderLoadAfterTenSeconds) {
  for (const bool guarded : {true, false}) {
    DriveBench b("4");
    b.set([&](Settings& s) { s.input_phase_guard = guarded ? 1 : 0; });
    b.load(b.fan());
    b.start(60);
    b.run(10s);
    MainsInput lost;
    lost.connected = {true, true, false};
    b.axis.advance_to(b.loop.now());
    b.axis.bus().set_mains(lost);
    const double t = b.until_trip(12s);
    if (guarded) {
      EXPECT_NEAR(t, 10, 0.3);
      EXPECT_EQ(b.drive.trip(), Trip::kEphi);
    } else {
      EXPECT_FALSE(b.drive.tripped()) << trip_of(b);
    }
  }
}

TEST(Asd7Drive, LowCurrentAndOverTorqueTripOnlyWhereTheyAreAsked) {
  DriveBench b("0.75");
  b.set([](Settings& s) {
    s.low_current = 60;
    s.low_current_time = 2;
  });
  b.start(30);
  b.run(8s);
  EXPECT_FALSE(b.drive.tripped());
  EXPECT_NE(b.drive.alarms() & kAlarmLowCurrent, 0);
  b.set([](Settings& s) { s.low_current_trip = 1; });
  b.run(10ms);
  EXPECT_EQ(b.drive.trip(), Trip::kUc);

  DriveBench torque("0.75");
  torque.set([](Settings& s) {
    s.over_torque_trip = 1;
    s.over_torque = 80;
  });
  torque.load(torque.fan(1.3));
  torque.start(60);
  EXPECT_LT(torque.until_trip(12s), 12);
  EXPECT_EQ(torque.drive.trip(), Trip::kOt);
}

TEST(Asd7Drive, AHotHeatSinkTripsAndTheTerminalAndInjectedCausesToo) {
  DriveBench b("0.75");
  b.drive.set_ambient_degc(86);
  b.run(10ms);
  EXPECT_NE(b.drive.alarms() & kAlarmHeatSink, 0);
  b.drive.set_ambient_degc(96);
  b.run(10ms);
  EXPECT_EQ(b.drive.trip(), Trip::kOh);

  DriveBench c("0.75");
  Terminals pins;
  pins.thermistor = true;
  c.drive.set_terminals(pins);
  c.run(10ms);
  EXPECT_EQ(c.drive.trip(), Trip::kOh2);

  DriveBench d("0.75");
  d.drive.inject(Trip::kEf2);
  d.run(1s);
  EXPECT_FALSE(d.drive.tripped()) << "an earth fault shows while the output is on";
  d.start(20);
  d.run(10ms);
  EXPECT_EQ(d.drive.trip(), Trip::kEf2);
  EXPECT_EQ(d.drive.set_command(kCommandReset), AcDrive::CommandResult::kRestarts);
  d.run(2100ms);
  d.start(20);
  d.run(10ms);
  EXPECT_EQ(d.drive.trip(), Trip::kEf2) << "a lasting cause trips again";

  DriveBench e("0.75");
  e.drive.inject(Trip::kOca);
  e.run(10ms);
  EXPECT_FALSE(e.drive.tripped());
  e.start(20);
  e.run(10ms);
  EXPECT_EQ(e.drive.trip(), Trip::kOca);
}

// --- Emergency, reset, memory --------------------------------------------------------------------

TEST(Asd7Drive, EmergencyStopTripsAndAResetRestartsTheCpu) {
  DriveBench b("0.75");
  int started = 0, stopped = 0;
  b.drive.set_on_start([&] { ++started; });
  b.drive.set_on_stop([&] { ++stopped; });
  b.start(30);
  b.run(5s);
  const Monitor before = b.drive.monitor();
  EXPECT_EQ(b.drive.set_command(0xd400), AcDrive::CommandResult::kTaken);
  b.run(10ms);
  EXPECT_EQ(b.drive.trip(), Trip::kE);
  EXPECT_EQ(b.status(), 0x1003);
  EXPECT_EQ(b.drive.frozen().output_frequency, 3000);
  EXPECT_EQ(b.drive.frozen().output_current, before.output_current);
  EXPECT_EQ(b.hz(), 0);
  EXPECT_TRUE(b.drive.fault_relay());
  EXPECT_EQ(b.drive.memory().past_trips[0], 0x11);
  EXPECT_EQ(b.drive.memory().eeprom_writes, 1U);
  EXPECT_EQ(b.drive.set_command(kCommandReset), AcDrive::CommandResult::kRestarts);
  EXPECT_FALSE(b.drive.alive());
  EXPECT_EQ(stopped, 1);
  EXPECT_EQ(started, 0);
  b.run(1990ms);
  EXPECT_FALSE(b.drive.alive());
  EXPECT_EQ(b.drive.set_command(kRunByLine), AcDrive::CommandResult::kIgnored);
  b.run(20ms);
  EXPECT_TRUE(b.drive.alive());
  EXPECT_EQ(started, 1);
  EXPECT_EQ(b.drive.command(), 0);
  EXPECT_EQ(b.drive.frequency(), 0);
  EXPECT_EQ(b.drive.trip(), Trip::kNone);
  EXPECT_EQ(b.drive.set_command(kCommandReset), AcDrive::CommandResult::kIgnored);
}

TEST(Asd7Drive, EmergencyStopMayRampOrBrakeFirst) {
  DriveBench b("0.75");
  b.set([](Settings& s) { s.emergency_stop = 1; });
  b.start(30);
  b.run(5s);
  b.drive.set_command(0xd400);
  b.run(1s);
  EXPECT_FALSE(b.drive.tripped());
  EXPECT_NEAR(b.hz(), 22, 0.1);
  b.run(4s);
  EXPECT_EQ(b.drive.trip(), Trip::kE);
  EXPECT_NEAR(b.rpm(), 0, 30);

  DriveBench c("0.75");
  c.set([](Settings& s) { s.emergency_stop = 2; });
  c.start(30);
  c.run(5s);
  c.drive.set_command(0xd400);
  c.run(800ms);
  EXPECT_NE(c.status() & kStatusDcBraking, 0);
  c.run(2s);
  EXPECT_EQ(c.drive.trip(), Trip::kE);
  EXPECT_NEAR(c.rpm(), 0, 30);
}

TEST(Asd7Drive, ASilentLineTripsAsConfigured) {
  for (const int action : {0, 1, 2}) {
    DriveBench b("0.75");
    b.set([&](Settings& s) { s.time_out_action = static_cast<std::uint16_t>(action); });
    b.start(20);
    b.run(3s);
    b.drive.communication_lost();
    b.run(10ms);
    EXPECT_EQ(b.drive.tripped(), action == 1);
    b.run(4s);
    EXPECT_EQ(b.drive.trip(), action == 0 ? Trip::kNone : Trip::kErr5);
    EXPECT_EQ((b.drive.alarms() & kAlarmCommunication) != 0, action == 0);
  }
}

TEST(Asd7Drive, TheLastFourTripsAreKept) {
  Memory memory;
  memory.past_trips = {1, 2, 3, 4};
  DriveBench b("0.75", {.memory = memory});
  b.drive.eeprom_failed(Trip::kEep3);
  EXPECT_EQ(b.drive.memory().past_trips, (std::array<std::uint8_t, 4>{0x14, 1, 2, 3}));
}

TEST(Asd7Drive, HoursAndEnergyCount) {
  DriveBench b("0.75");
  b.load(b.fan());
  b.start(60);
  b.run(40s);
  EXPECT_NEAR(static_cast<double>(b.drive.memory().run_seconds), 40, 1);
  const Monitor m = b.drive.monitor();
  EXPECT_NEAR(m.output_power, 92, 6);
  EXPECT_GT(m.input_power, m.output_power);
  EXPECT_NEAR(b.drive.memory().output_kwh, 0.92 * 35 / 3600, 0.002);
}

TEST(Asd7Drive, ThePanelRunsAndStopsIt) {
  DriveBench b("0.75");
  b.set([](Settings& s) { s.command_source = 1; });
  b.drive.set_panel_frequency(1500);
  b.drive.press(PanelKey::kRun);
  b.run(3s);
  EXPECT_EQ(b.hz(), 15);
  b.drive.press(PanelKey::kStop);
  b.run(3s);
  EXPECT_EQ(b.status(), 0x4000);
  b.set([](Settings& s) { s.command_source = 0; });
  b.start(15);
  b.run(1s);
  b.drive.press(PanelKey::kStop);
  b.run(300ms);
  EXPECT_EQ(b.drive.trip(), Trip::kNone);
  b.drive.press(PanelKey::kStop);
  b.run(10ms);
  EXPECT_EQ(b.drive.trip(), Trip::kE);
}

TEST(Asd7Drive, RetriesAfterATripAndGivesUp) {
  DriveBench b("0.75");
  b.set([](Settings& s) {
    s.retries = 2;
    s.acceleration1 = 1;
    s.stall_level1 = 200;
  });
  b.load({.locked = true});
  b.start(60);
  b.run(500ms);
  EXPECT_EQ(b.status(), 0x0002) << "waits, no fault signal yet";
  b.run(20s);
  EXPECT_EQ(b.status(), 0x0003);
  EXPECT_EQ(b.drive.memory().eeprom_writes, 1U) << "one trip, not three";
}

// --- Power ---------------------------------------------------------------------------------------

TEST(Asd7Drive, AShortDipRidesThroughOnTheCapacitor) {
  DriveBench b("0.75");
  b.load(b.fan(0.5));
  b.start(40);
  b.run(8s);
  b.mains(false);
  b.run(10ms);
  b.mains(true);
  b.run(1s);
  EXPECT_EQ(b.status(), 0x6400);
  EXPECT_EQ(b.hz(), 40);
}

TEST(Asd7Drive, ALongerOneStopsTheOutputAndItStartsAgainFromZero) {
  DriveBench b("0.75");
  b.load(b.fan(1, 20));
  b.start(40);
  b.run(8s);
  b.mains(false);
  b.run(120ms);
  EXPECT_EQ(b.status(), 0x0008);
  EXPECT_NE(b.drive.alarms() & kAlarmUnderVoltage, 0);
  b.mains(true);
  b.run(600ms);
  EXPECT_EQ(b.status(), 0x6400);
  EXPECT_LT(b.hz(), 10);
}

TEST(Asd7Drive, MayTripOnUndervoltage) {
  DriveBench b("0.75");
  b.set([](Settings& s) { s.undervoltage_trip = 1; });
  b.load(b.fan());
  b.start(40);
  b.run(8s);
  b.mains(false);
  EXPECT_LT(b.until_trip(1s), 0.3);
  EXPECT_EQ(b.drive.trip(), Trip::kUp1);
}

TEST(Asd7Drive, RidesThroughOnTheLoadsEnergy) {
  DriveBench b("4");
  b.set([](Settings& s) { s.ride_through = 1; });
  b.load(b.fan(0.5, 20));
  b.start(50);
  b.run(10s);
  b.mains(false);
  b.run(500ms);
  EXPECT_NE(b.status() & kStatusRunning, 0) << "bus " << b.drive.bus_v();
  EXPECT_LT(b.hz(), 49);
  EXPECT_GT(b.drive.bus_v(), 400);
  b.mains(true);
  b.run(6s);
  EXPECT_EQ(b.hz(), 50);
  EXPECT_EQ(b.drive.trip(), Trip::kNone);
}

TEST(Asd7Drive, MayStopWhenThePowerGoesAndSaysSo) {
  DriveBench b("4");
  b.set([](Settings& s) { s.ride_through = 2; });
  b.load(b.fan(0.5, 20));
  b.start(50);
  b.run(10s);
  b.mains(false);
  b.run(100ms);
  b.mains(true);
  b.run(12s);
  EXPECT_EQ(b.drive.trip(), Trip::kNone) << trip_of(b);
  EXPECT_EQ(b.hz(), 0);
  EXPECT_NE(b.drive.alarms() & kAlarmPowerLossStop, 0);
  b.stop();
  b.run(10ms);
  b.start(20);
  b.run(2s);
  EXPECT_GT(b.hz(), 10) << "a new run command starts it";
}

TEST(Asd7Drive, OnePhaseOfSupplyFeedsTheSmallest) {
  DriveBench b("0.75", {.phases = 1});
  b.load(b.fan(0.6));
  b.set([](Settings& s) { s.input_phase_guard = 0; });
  b.start(50);
  b.run(18s);
  EXPECT_EQ(b.hz(), 50) << trip_of(b);
  double highest = 0, lowest = 1000;
  for (int i = 0; i < 200; ++i) {
    b.run(100us);
    highest = std::max(highest, b.axis.state().bus_v);
    lowest = std::min(lowest, b.axis.state().bus_v);
  }
  EXPECT_GT(highest - lowest, 5);
  EXPECT_LT(highest - lowest, 40);
}

TEST(Asd7Drive, FindsATurningMotor) {
  DriveBench b("4");
  b.set([](Settings& s) { s.flying_start = 1; });
  b.load(b.fan(0.5, 40));
  b.start(50);
  b.run(10s);
  b.mains(false);
  b.run(800ms);
  EXPECT_EQ(b.status() & kStatusRunning, 0);
  const double coasting_rpm = b.rpm();
  EXPECT_GT(coasting_rpm, 900);
  b.mains(true);
  double least = coasting_rpm, most_a = 0;
  for (int i = 0; i < 400; ++i) {
    b.run(10ms);
    least = std::min(least, b.rpm());
    most_a = std::max(most_a, b.current_percent());
  }
  EXPECT_GT(least, 0.75 * coasting_rpm);
  EXPECT_LT(most_a, 170);
  b.run(6s);
  EXPECT_EQ(b.hz(), 50) << trip_of(b);
}

TEST(Asd7Drive, WithoutMainsItDiesAndComesBackAfterASecond) {
  DriveBench b("0.75");
  int started = 0;
  b.drive.set_on_start([&] { ++started; });
  b.set([](Settings& s) { s.keep_trip = 1; });
  b.start(20);
  b.run(1s);
  b.drive.set_command(0xd400);
  b.run(10ms);
  ASSERT_EQ(b.drive.trip(), Trip::kE);
  b.mains(false);
  b.run(5s);
  EXPECT_FALSE(b.drive.alive());
  EXPECT_EQ(b.status(), 0);
  b.mains(true);
  b.run(900ms);
  EXPECT_FALSE(b.drive.alive());
  b.run(500ms);
  EXPECT_TRUE(b.drive.alive());
  EXPECT_EQ(started, 1);
  EXPECT_EQ(b.drive.trip(), Trip::kE) << "F602 keeps it";
}

// --- Repeatable ----------------------------------------------------------------------------------

TEST(Asd7Drive, EqualRunsAreEqualToTheBit) {
  double speed[2] = {};
  std::uint64_t ticks[2] = {};
  for (int i = 0; i < 2; ++i) {
    DriveBench b("0.75");
    b.load(b.fan());
    b.start(30);
    b.run(2s);
    speed[i] = b.axis.state().speed_radps;
    ticks[i] = b.drive.ticks();
  }
  EXPECT_EQ(speed[0], speed[1]);
  EXPECT_EQ(ticks[0], ticks[1]);
}

TEST(Asd7Drive, BothIntegratorsGiveTheSameRun) {
  double rpm[2] = {}, bus_v[2] = {};
  int i = 0;
  for (const Integrator integrator : {Integrator::kFast, Integrator::kDefault}) {
    DriveBench b("0.75", {.integrator = integrator});
    b.load(b.fan());
    b.start(20);
    b.run(1500ms);
    rpm[i] = b.rpm();
    bus_v[i++] = b.axis.state().bus_v;
  }
  EXPECT_NEAR(rpm[0] / rpm[1], 1, 2e-4);
  EXPECT_NEAR(bus_v[0], bus_v[1], 0.5);
}

TEST(Asd7Drive, AStoppedDriveCostsNextToNothing) {
  DriveBench b("0.75");
  b.start(10);
  b.run(2s);
  b.stop();
  b.run(20s);
  EXPECT_TRUE(b.axis.at_rest());
  const std::uint64_t before = b.axis.counters().derivative_evaluations;
  b.run(60s);
  EXPECT_EQ(b.axis.counters().derivative_evaluations, before);
}

}  // namespace
}  // namespace virtdrive::asd7
