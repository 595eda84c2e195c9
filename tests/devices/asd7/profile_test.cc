#include "devices/asd7/profile.h"

#include <gtest/gtest.h>

#include "core/check.h"

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;

TEST(Asd7Profile, EachSwitchTakesEachOfItsWordsAndNoOther) {
  for (const ProfileSetting& setting : profile_settings()) {
    Profile profile;
    EXPECT_FALSE(setting.doc.empty()) << setting.name;
    std::string_view words = setting.values;
    while (setting.values != "milliseconds") {
      EXPECT_TRUE(set_profile(profile, setting.name, words.substr(0, words.find('|'))));
      if (words.find('|') == std::string_view::npos) break;
      words.remove_prefix(words.find('|') + 1);
    }
    EXPECT_THROW(set_profile(profile, setting.name, "maybe"), SetupError) << setting.name;
  }
}

TEST(Asd7Profile, SwitchesSetWhatTheySay) {
  Profile profile;
  set_profile(profile, "error_sum", "always");
  set_profile(profile, "mode_error", "1");
  set_profile(profile, "timeout_unit", "0.1s");
  set_profile(profile, "timeout_actions", "p9");
  set_profile(profile, "frame_timeout", "5ms");
  EXPECT_TRUE(profile.error_sum_always);
  EXPECT_EQ(profile.mode_error, Error::kRange);
  EXPECT_EQ(profile.time_out_unit, 100ms);
  EXPECT_EQ(profile.time_out_actions, TimeOutActions::kMatrix);
  EXPECT_EQ(profile.frame_time_out, 5ms);
  EXPECT_FALSE(set_profile(profile, "ACC", "5s"));
}

}  // namespace
}  // namespace virtdrive::asd7
