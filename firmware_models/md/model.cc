#include "firmware_models/md/model.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace virtdrive::md {
namespace {

// DC links by supply class. Assumed, as are the link's capacitors (1 mF up to 10 A, 2.2 mF at
// 20 and 30 A, 6.8 mF above, 330 uF behind a rectifier).
constexpr BusLimits k24V{.off_below = 10, .over = 35};
constexpr BusLimits k48V{.off_below = 10, .over = 60};
constexpr BusLimits k2K{.off_below = 20, .over = 60};
constexpr BusLimits k72V{.off_below = 20, .over = 90};
constexpr BusLimits kAc{.off_below = 110, .over = 420};
constexpr double kRectifiedV = 311;  // 220 V AC

constexpr bool o = true;
constexpr bool x = false;

// clang-format off
//  name       title      supply V    AC  A    motors RS485 TTL CAN ENC PULSE RC CLUTCH POW
//  baud motor      bus V        limits C       temperature poles rpm   torque
constexpr std::array kModels = std::to_array<Model>({
    {"md50",   "MD50",    12, 24,     x,  3,   1,     x,    x,  x,  x,  x,    x, x,     x,
     2, "md50",     24,          k24V, 1e-3,   x, 1,  3000, 0.159},
    {"md50c",  "MD50C",   12, 24,     x,  3.5, 1,     o,    x,  x,  o,  x,    x, x,     x,
     2, "md50c",    24,          k24V, 1e-3,   x, 1,  3000, 0.191},
    {"pnt50",  "PNT50",   12, 24,     x,  3,   2,     o,    x,  x,  o,  x,    x, x,     x,
     2, "md50",     24,          k24V, 1e-3,   x, 1,  3000, 0.159},
    {"md100",  "MD100",   12, 24,     x,  7,   1,     x,    x,  x,  x,  x,    x, x,     x,
     2, "md100",    24,          k24V, 1e-3,   x, 1,  3000, 0.318},
    {"md200",  "MD200",   12, 48,     x,  10,  1,     o,    x,  x,  o,  x,    x, x,     o,
     2, "md200",    24,          k48V, 1e-3,   o, 1,  3000, 0.477},
    {"md200t", "MD200T",  12, 48,     x,  10,  2,     o,    x,  x,  o,  o,    x, o,     o,
     2, "md200t",   24,          k48V, 1e-3,   o, 10, 400,  3.18},
    {"md400",  "MD400",   12, 48,     x,  20,  1,     o,    o,  x,  o,  o,    o, o,     o,
     2, "md400",    48,          k48V, 2.2e-3, o, 2,  3000, 1.27},
    {"md400t", "MD400T",  12, 48,     x,  20,  2,     o,    o,  o,  o,  o,    o, o,     o,
     2, "md400",    48,          k48V, 2.2e-3, o, 2,  3000, 1.27},
    {"md500s", "MD500S",  12, 48,     x,  20,  1,     o,    x,  x,  o,  o,    o, o,     o,
     2, "md500s",   48,          k48V, 2.2e-3, o, 2,  3000, 1.59},
    {"md750",  "MD750",   24, 72,     x,  30,  1,     o,    o,  o,  o,  o,    o, o,     o,
     2, "md750",    48,          k72V, 2.2e-3, o, 2,  3000, 2.39},
    {"md750t", "MD750T",  24, 72,     x,  30,  2,     o,    o,  o,  o,  o,    o, o,     o,
     2, "md750",    48,          k72V, 2.2e-3, o, 2,  3000, 2.39},
    {"md1k",   "MD1K",    12, 48,     x,  50,  1,     o,    o,  o,  o,  o,    o, o,     o,
     2, "md1k",     48,          k48V, 6.8e-3, o, 2,  3000, 3.18},
    {"md2k",   "MD2K",    24, 48,     x,  100, 1,     o,    o,  o,  o,  x,    o, o,     o,
     2, "md2k",     48,          k2K,  6.8e-3, o, 2,  3000, 6.37},
    {"mda200", "MDA200",  110, 220,   o,  1.5, 1,     o,    o,  x,  o,  x,    x, x,     x,
     1, "mda200",   kRectifiedV, kAc,  330e-6, o, 1,  3000, 0.637},
    {"mda400", "MDA400",  110, 220,   o,  2.5, 1,     o,    o,  o,  o,  x,    x, x,     x,
     1, "mda400",   kRectifiedV, kAc,  330e-6, o, 1,  3000, 1.27},
    {"mda400c", "MDA400C", 110, 220,  o,  2.5, 1,     o,    o,  x,  o,  o,    o, x,     x,
     2, "mda400",   kRectifiedV, kAc,  330e-6, o, 1,  3000, 1.27},
    {"mda1k",  "MDA1K",   110, 220,   o,  5,   1,     o,    o,  o,  o,  o,    o, o,     x,
     2, "mda1k",    kRectifiedV, kAc,  330e-6, o, 1,  3000, 3.18},
});
// clang-format on

}  // namespace

std::span<const Model> models() {
  return kModels;
}

Settings default_settings(const Model& model) {
  Settings settings;
  settings.baud_code = model.baud_code;
  settings.hall_type = model.hall_type;
  settings.max_rpm = model.max_rpm;
  settings.max_load = static_cast<std::int32_t>(std::lround(10 * model.current_a));
  if (model.name == "md200t") {
    // The set that was read out of a real MD200T with two in-wheel motors; ENC_PPR is left at 0, an
    // encoder that is not there would be ENC_FAIL.
    settings.use_limit_sw = 0;
    settings.zero_vel_ctrl = 1;
    settings.regeneration = 1;
    settings.slow_start = settings.slow_down = 100;
    settings.p_gain = settings.i_gain = 6000;
    settings.tar_posi_vel = 1110;
    settings.low_speed_limit = 5;
    settings.high_speed_limit = 1000;
    settings.max_load = 118;
  }
  return settings;
}

double max_load_a(const Model& model, const Settings& settings) {
  if (settings.max_load == 0) return model.current_a;
  return std::min(settings.max_load / 10.0, 1.5 * model.current_a);
}

}  // namespace virtdrive::md
