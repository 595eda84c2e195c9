#include "devices/asd7/profile.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/format.h>
#include <string>
#include <vector>

#include "core/check.h"
#include "core/names.h"

namespace virtdrive::asd7 {
namespace {

using namespace std::chrono_literals;

// Takes the number of the choice, or the milliseconds.
using Put = void (*)(Profile&, int);

struct Entry {
  ProfileSetting setting;
  Put put;
};

constexpr std::string_view kMilliseconds = "milliseconds";

constexpr auto kEntries = std::to_array<Entry>({
    {{"error_sum", "mirror|always",
      "ASCII error replies carry a sum as the request does, or always"},
     [](Profile& p, int n) { p.error_sum_always = n == 1; }},
    {{"broadcast_read", "silent|answered", "R and G to all drives or a group"},
     [](Profile& p, int n) { p.broadcast_read = n == 1; }},
    {{"ascii_wide", "off|on", "L before the command in ASCII: 32-bit access"},
     [](Profile& p, int n) { p.ascii_wide = n == 1; }},
    {{"mode_error", "0|1|2|3|4", "Error code of a value that 16 bits do not hold"},
     [](Profile& p, int n) { p.mode_error = static_cast<Error>(n); }},
    {{"status_bit14", "ready|faulted", "Bit 14 of FD01 and FE01"},
     [](Profile& p, int n) { p.bit14_faulted = n == 1; }},
    {{"signed_frequency", "off|on", "FD00, FD02 and what is held of them are negative in reverse"},
     [](Profile& p, int n) { p.signed_frequency = n == 1; }},
    {{"timeout_unit", "1s|0.1s", "Unit of F803"},
     [](Profile& p, int n) { p.time_out_unit = n == 1 ? 100ms : 1s; }},
    {{"timeout_actions", "s15|p9", "How F804 is read: VF-S15's 0 to 2, or P9's 0 to 8"},
     [](Profile& p, int n) { p.time_out_actions = static_cast<TimeOutActions>(n); }},
    {{"frame_timeout", kMilliseconds, "An unfinished frame is given up after so long"},
     [](Profile& p, int n) { p.frame_time_out = n * 1ms; }},
    {{"reply_time", kMilliseconds, "From a request to its answer, at least"},
     [](Profile& p, int n) { p.reply_time = n * 1ms; }},
    {{"write_time", kMilliseconds, "The same of a write into the EEPROM"},
     [](Profile& p, int n) { p.write_time = n * 1ms; }},
});

constexpr auto kSettings = [] {
  std::array<ProfileSetting, kEntries.size()> settings{};
  for (std::size_t i = 0; i < kEntries.size(); ++i) settings[i] = kEntries[i].setting;
  return settings;
}();

std::vector<std::string_view> choices(std::string_view values) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t bar = values.find('|');
    parts.push_back(values.substr(0, bar));
    if (bar == std::string_view::npos) return parts;
    values.remove_prefix(bar + 1);
  }
}

int milliseconds(std::string_view name, std::string_view value) {
  std::string_view digits = value;
  if (digits.ends_with("ms")) digits.remove_suffix(2);
  int number = 0;
  const char* const end = digits.data() + digits.size();
  const auto [stop, error] = std::from_chars(digits.data(), end, number);
  if (error != std::errc{} || stop != end || number < 0 || number > 60'000) {
    throw SetupError(fmt::format("{}={}: expected 0 to 60000 milliseconds", name, value));
  }
  return number;
}

}  // namespace

std::span<const ProfileSetting> profile_settings() {
  return kSettings;
}

bool set_profile(Profile& profile, std::string_view name, std::string_view value) {
  const auto* const it =
      std::ranges::find(kEntries, name, [](const Entry& entry) { return entry.setting.name; });
  if (it == kEntries.end()) return false;
  if (it->setting.values == kMilliseconds) {
    it->put(profile, milliseconds(name, value));
    return true;
  }
  const auto words = choices(it->setting.values);
  const auto word = std::ranges::find(words, value);
  if (word == words.end()) throw SetupError(unknown_name(name, value, words));
  it->put(profile, static_cast<int>(word - words.begin()));
  return true;
}

}  // namespace virtdrive::asd7
