// The special functions' timing diagrams (p. 29, 30) and the sweeps of the speed inputs (p. 8 ..
// 15), millisecond by millisecond.
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/firmware_models/md/rig.h"

namespace virtdrive::md {
namespace {

using namespace std::chrono_literals;

enum Function { kSpeed = 1, kPosition, kMomentary, kAdd };

constexpr int kDelayMs = 500;

// START/STOP on at one instant, off at the next, and so on; by pin or by PID 184.
struct Diagram {
  int function;
  std::vector<int> edges_ms;
  std::vector<int> running_ms;  // from, to, from, to ...
};

class TimingDiagram : public testing::Test {
 protected:
  void begin(int function) {
    rig_ = std::make_unique<Rig>();
    rig_->pins().start = false;
    rig_->change(&Settings::func_type, function);
    rig_->change(&Settings::func_speed, 600);
    rig_->change(&Settings::func_delay, kDelayMs / 100);
    rig_->run_for(20ms);
  }

  /// When the reference began and ceased to be that of FUNC_SPEED.
  std::vector<int> run(const Diagram& diagram, bool by_frame) {
    begin(diagram.function);
    std::vector<int> running;
    bool on = false, runs = false;
    std::size_t next = 0;
    for (int ms = 0; ms < 4000; ++ms) {
      if (next < diagram.edges_ms.size() && diagram.edges_ms[next] == ms) {
        on = !on;
        ++next;
        if (by_frame)
          rig_->controller->function_signal(on);
        else
          rig_->pins().start = on;
      }
      rig_->run_for(1ms);
      const int reference = rig_->motor().reference_rpm();
      EXPECT_TRUE(reference == 0 || reference == 600) << reference;
      if ((reference != 0) != runs) running.push_back(ms);
      runs = reference != 0;
    }
    return running;
  }

  void check(const Diagram& diagram) {
    for (const bool by_frame : {false, true}) {
      const std::vector<int> running = run(diagram, by_frame);
      ASSERT_EQ(running.size(), diagram.running_ms.size()) << by_frame;
      for (std::size_t i = 0; i < running.size(); ++i) {
        EXPECT_NEAR(running[i], diagram.running_ms[i], 2) << i << (by_frame ? " frame" : " pin");
      }
      EXPECT_EQ(rig_->motor().status(), 0);
    }
  }

  std::unique_ptr<Rig> rig_;
};

TEST_F(TimingDiagram, SpeedRunsForItsDelayFromEachEdge) {
  check({kSpeed, {100, 200, 1000, 2200}, {100, 600, 1000, 1500}});
}

TEST_F(TimingDiagram, SpeedBeginsItsDelayAnewWithAnEdgeWhileItRuns) {
  check({kSpeed, {100, 200, 400, 450, 800, 3900}, {100, 1300}});
}

TEST_F(TimingDiagram, MomentaryRunsExactlyWhileTheSignalIsOn) {
  check({kMomentary, {100, 200, 1000, 2500}, {100, 200, 1000, 2500}});
}

TEST_F(TimingDiagram, AddRunsForItsDelayBehindEachSignal) {
  check({kAdd, {100, 200, 1000, 2500}, {100, 700, 1000, 3000}});
}

TEST_F(TimingDiagram, AddGoesOnWhenTheSignalComesAgainInItsDelay) {
  check({kAdd, {100, 200, 600, 700, 1100, 1200}, {100, 1700}});
}

TEST_F(TimingDiagram, PositionMovesOnceAnEdgeHoweverLongTheSignal) {
  for (const bool by_frame : {false, true}) {
    begin(kPosition);
    rig_->change(&Settings::func_posi_speed, -900);  // a magnitude
    rig_->change(&Settings::func_posi_increment, 90);
    std::vector<int> targets;
    for (const bool on : {true, false, true, false}) {
      if (by_frame)
        rig_->controller->function_signal(on);
      else
        rig_->pins().start = on;
      rig_->run_for(3s);
      targets.push_back(rig_->motor().target_position());
      EXPECT_NEAR(rig_->motor().position(), targets.back(), 2);
    }
    EXPECT_NEAR(targets[0], 90, 1);
    EXPECT_EQ(targets[1], targets[0]);
    EXPECT_NEAR(targets[2], 180, 2);
    EXPECT_EQ(targets[3], targets[2]);
  }
}

TEST_F(TimingDiagram, AnAlarmAFreeAndABrakeEndIt) {
  for (const int how : {0, 1, 2}) {
    begin(kAdd);
    rig_->pins().start = true;
    rig_->run_for(300ms);
    EXPECT_EQ(rig_->motor().reference_rpm(), 600);
    if (how == 0) rig_->controller->free(0);
    if (how == 1) rig_->controller->brake(0);
    if (how == 2) {
      StageSensors broken;
      broken.hall.output.fill(HallSensors::Output::kStuckHigh);
      rig_->controller->stage(0).set_sensors(broken);
    }
    rig_->run_for(50ms);
    EXPECT_EQ(rig_->motor().reference_rpm(), 0) << how;
    EXPECT_EQ(rig_->motor().type(), ControlType::kOff) << how;
  }
}

TEST_F(TimingDiagram, ItsRampsAreThoseOfSlowStartAndSlowDown) {
  begin(kMomentary);
  rig_->change(&Settings::slow_start, 205);  // 3 s to 3000 rpm
  rig_->change(&Settings::slow_down, 68);    // 1 s
  rig_->pins().start = true;
  rig_->run_for(300ms);
  EXPECT_NEAR(rig_->motor().reference_rpm(), 300, 5);
  rig_->run_for(500ms);
  EXPECT_EQ(rig_->motor().reference_rpm(), 600);
  rig_->pins().start = false;
  rig_->run_for(100ms);
  EXPECT_NEAR(rig_->motor().reference_rpm(), 300, 5);
}

TEST_F(TimingDiagram, NoEdgeIsSeenWhenTheFunctionIsChosen) {
  Rig rig;  // START is on
  rig.run_for(20ms);
  rig.change(&Settings::func_type, kMomentary);
  rig.change(&Settings::func_speed, 600);
  rig.run_for(100ms);
  EXPECT_EQ(rig.motor().reference_rpm(), 0);
}

// --- The five inputs, swept ----------------------------------------------------------------------

// The reference that the terminals give at each step of a sweep from `from` to `to`.
template <class Pin>
std::vector<double> sweep(InputType type, Pin Terminals::* pin, double from, double to, int steps,
                          std::int32_t dead_zone = 100) {
  Rig rig;
  rig.pins().cw = false;
  rig.change(&Settings::input_type, static_cast<std::int32_t>(type));
  rig.change(&Settings::dead_zone, dead_zone);
  rig.change(&Settings::max_rpm, 1023);
  std::vector<double> references;
  for (int i = 0; i <= steps; ++i) {
    rig.pins().*pin = static_cast<Pin>(from + (to - from) * i / steps);
    rig.run_for(4ms);
    references.push_back(rig.motor().reference_rpm());
  }
  return references;
}

void expect_line(const std::vector<double>& references, std::size_t from, std::size_t to,
                 double first, double last) {
  for (std::size_t i = from; i <= to; ++i) {
    const double share = double(i - from) / double(to - from);
    ASSERT_NEAR(references[i], first + (last - first) * share, 3) << i;
  }
}

TEST(MdSweep, AnalogIsALineFromNoughtToFiveVolts) {
  expect_line(sweep(InputType::kAnalog, &Terminals::speed_v, 0, 5, 100), 0, 100, 0, 1023);
}

TEST(MdSweep, PwmIsTheSameLineOverItsDuty) {
  expect_line(sweep(InputType::kAnalog, &Terminals::pwm_duty, 0.01, 1, 99), 0, 99, 10, 1023);
}

// 100 of 1023 counts around the middle: 2.01 .. 2.99 V.
TEST(MdSweep, TheJoystickGoesFromFullBackwardOverItsDeadZoneToFullForward) {
  const auto references = sweep(InputType::kJoystick, &Terminals::speed_v, 0, 5, 100);
  expect_line(references, 0, 40, -1023, -1023.0 * (1023 - 2 * 409 - 200) / (1023 - 200));
  for (std::size_t i = 41; i <= 59; ++i) EXPECT_EQ(references[i], 0) << i;
  expect_line(references, 60, 100, 1023.0 * (2 * 614 - 1023 - 200) / (1023 - 200), 1023);
}

TEST(MdSweep, PulsesAreALineUpToHalfAMegahertz) {
  const auto references = sweep(InputType::kPulse, &Terminals::pulse_hz, 0, 600e3, 120);
  EXPECT_EQ(references[0], 0);
  expect_line(references, 1, 100, 1023.0 * 0.01, 1023);
  for (std::size_t i = 100; i <= 120; ++i) EXPECT_EQ(references[i], 1023);
}

// Dead zone 100 of a half scale of 511.5: +-0.088 ms.
TEST(MdSweep, AServoPulseGoesFromFullBackwardOverItsDeadZoneToFullForward) {
  const auto references = sweep(InputType::kRcServo, &Terminals::rc_ms, 1.05, 1.95, 90);
  const double nearest = 1023.0 * (1023 * 0.09 / 0.45 - 200) / (1023 - 200);
  expect_line(references, 0, 36, -1023, -nearest);
  for (std::size_t i = 37; i <= 53; ++i) EXPECT_EQ(references[i], 0) << i;
  expect_line(references, 54, 90, nearest, 1023);
  EXPECT_EQ(sweep(InputType::kRcServo, &Terminals::rc_ms, 0, 0, 1).back(), 0);  // no pulse
  EXPECT_EQ(sweep(InputType::kRcServo, &Terminals::rc_ms, 0.5, 0.5, 1).back(), -1023);
}

TEST(MdSweep, StepsAreSevenSpeedsOfTheirOwnInBothDirections) {
  Rig rig;
  rig.change(&Settings::input_type, static_cast<std::int32_t>(InputType::kStep));
  Settings settings = rig.controller->settings();
  settings.steps[2] = -450;
  rig.controller->set_settings(settings);
  for (const bool cw : {false, true}) {
    rig.pins().cw = cw;
    for (int step = 0; step <= 7; ++step) {
      rig.pins().int_speed = (step & 1) != 0;
      rig.pins().run = (step & 2) != 0;
      rig.pins().start = (step & 4) != 0;
      rig.run_for(5ms);
      const int rpm = step == 3 ? -450 : 3000 * step / 7;
      EXPECT_EQ(rig.motor().reference_rpm(), cw ? -rpm : rpm) << step;
    }
  }
}

TEST(MdSweep, DirTurnsOneSidedInputs) {
  Rig rig;
  rig.pins().speed_v = 2.5;
  for (const bool cw : {true, false}) {
    rig.pins().cw = cw;
    rig.run_for(4ms);
    EXPECT_NEAR(rig.motor().reference_rpm(), cw ? -1500 : 1500, 5);
  }
}

}  // namespace
}  // namespace virtdrive::md
