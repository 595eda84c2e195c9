#include "scenarios/report/motor_page.h"

#include <gtest/gtest.h>

namespace virtdrive {
namespace {

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1))
    ++n;
  return n;
}

TEST(MotorPage, HoldsAllPlotsAndNeedsNothingElse) {
  const std::string svg = motor_svg(find_motor("ecma-c20807"));
  EXPECT_TRUE(svg.starts_with("<svg xmlns="));
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
  for (const char* part : {"Torque over speed", "Power at the shaft", "Current at the rated limit",
                           "Efficiency", "for a short time", "7.212 A peak", "97 %"}) {
    EXPECT_NE(svg.find(part), std::string::npos) << part;
  }
  for (const char* foreign : {"href", "url(http", "<script", "@import", "nan", "inf"}) {
    EXPECT_EQ(svg.find(foreign), std::string::npos) << foreign;
  }
  EXPECT_EQ(svg, motor_svg(find_motor("ecma-c20807"))) << "equal motors give equal pages";
}

TEST(MotorPage, EveryKindHasAPageInItsUnits) {
  const std::string coil = motor_svg(find_motor("voice-coil-20n"));
  for (const char* part : {"Force over speed", ">m/s<", ">N<", "Moving mass", "10 N/A"}) {
    EXPECT_NE(coil.find(part), std::string::npos) << part;
  }
  EXPECT_NE(motor_svg(find_motor("re40-24v")).find("7576 rpm"), std::string::npos);
  EXPECT_NE(motor_svg(find_motor("md100")).find("Torque over speed"), std::string::npos);
}

TEST(MotorPage, AMotorWithoutPeakCurrentHasOneTorqueCurve) {
  EXPECT_EQ(count(motor_svg(find_motor("db42s03")), "line orange"), 0U);
  EXPECT_GT(count(motor_svg(find_motor("servo-400w")), "line orange"), 0U);
}

TEST(MotorPage, WhatTheFileSaysIsEscaped) {
  Motor motor = find_motor("db42s03");
  motor.description = "<b>&\"";
  const std::string svg = motor_svg(motor);
  EXPECT_EQ(svg.find("<b>"), std::string::npos);
  EXPECT_NE(svg.find("&lt;b&gt;&amp;"), std::string::npos);
}

// Extremes of what a file may say: no resistance, no magnets, hardly any voltage.
TEST(MotorPage, OddMotorsHaveAPageToo) {
  const auto draw = [](const Motor& motor) {
    const std::string svg = motor_svg(motor);
    EXPECT_TRUE(svg.ends_with("</svg>\n"));
    EXPECT_EQ(svg.find("nan"), std::string::npos);
  };
  Motor motor = find_motor("ipmsm-2kw");
  motor.electrical.resistance_ohm = 0;
  draw(motor);
  motor.electrical.flux_wb = 0;
  draw(motor);
  Motor weak = find_motor("db42s03");
  weak.rating.voltage_v = 0.1;
  draw(weak);
  weak.mechanics.coulomb_nm = 1000;  // cannot even start
  draw(weak);
}

}  // namespace
}  // namespace virtdrive
