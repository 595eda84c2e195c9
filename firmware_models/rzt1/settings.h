// One axis' parameters, as Appendix A of R11AN0086 lists them: what a host writes and the servo
// obeys. The wire's widths, formats and ranges are the protocol table's; here every value is an
// int32, so that one pointer to member names any of them.
//
//   axis.set(&Settings::kp, 1500);             // with its side effects, refused where it must be
//   axis.settings().kp;                        // as written; the loops latch it at the next GO
//   pack(axis.saved());  unpack(bytes, into);  // what SAVE keeps
//
// The document gives neither factory values nor scaling for most; those here fit the bench's motor
// (servo-400w, 280 V, 131072 counts a turn).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace virtdrive::rzt1 {

struct Settings {
  // Module.
  std::int32_t type = 3;      // 60: 1 single, 2 dual and this axis leads the gear, 3 independent
  std::int32_t address = 1;   // 123
  std::int32_t group = 0;     // 124; 0: none
  std::int32_t gear_in = 1;   // 111, numerator
  std::int32_t gear_out = 1;  // 112, denominator
  std::int32_t data0 = 0, data1 = 0, data2 = 0, data3 = 0;  // 63..70, of the user
  std::int32_t data4 = 0, data5 = 0, data6 = 0, data7 = 0;

  // Motor and commutation.
  std::int32_t phases = 3;        // 71: 2 brushed or voice coil, 3 three phases
  std::int32_t brake = 0;         // 72, unused
  std::int32_t pole_pairs = 5;    // 33
  std::int32_t pmap = 0;          // 29: output channels U, V, W get phases UVW UWV VWU VUW WUV WVU
  std::int32_t pcmode = 1;        // 31: 0 voltage, 1 FOC, 2 Hall, 3 host
  std::int32_t pvector = 0;       // 32, times 60 degrees
  std::int32_t pimode = 0;        // 26: phasing 0 forced, 1 Hall, 2 dither
  std::int32_t pitime = 5000;     // 27, loop cycles
  std::int32_t piout = 1966;      // 28, 32767 = Vdc/3
  std::int32_t pioffs = 0;        // 36, counts
  std::int32_t porigin = 0;       // 30, counts; with an absolute encoder as the encoder counts
  std::int32_t padv = 0;          // 38, unused
  std::int32_t vcomp = 10;        // 39, unused
  std::int32_t hinvert = 0;       // 50
  std::int32_t hshift = -1;       // 51, unused
  std::int32_t htype = 0;         // 61, parallel
  std::int32_t pcounts = 26214;   // 34, counts per electrical turn
  std::int32_t ecpr = 131072;     // 35, counts per turn
  std::int32_t pinvert = 0;       // 114
  std::int32_t etype = 0;         // 117, EncoderType
  std::int32_t ebaudrate = 2500;  // 121, kbit/s
  std::int32_t eaddr = 0;         // 119
  std::int32_t pct = 0;           // 47
  std::int32_t sim = 0;           // 76: actual position = command, no PWM

  // Position loop, latched at ON, GO, STOP and ABORT but for MLIMIT and BIAS.
  std::int32_t kp = 2000, ki = 0, kd = 0;  // 14, 15, 16
  std::int32_t il = 32767;                 // 17
  std::int32_t vff = 32767, aff = 0;       // 18, 19
  std::int32_t max_error = 5000;           // 20 MAX, counts; 0: not watched
  std::int32_t etime = 500;                // 21, loop cycles
  std::int32_t ds = 2;                     // 22, loop cycle in 50 us
  std::int32_t mlimit = 32767;             // 23: 1024 counts a cycle
  std::int32_t bias = 0;                   // 24, 2^-16 counts a cycle
  std::int32_t astop = 0;                  // 25: 1: servo off after the stop
  // Velocity loop, latched like them.
  std::int32_t vkp = 12, vki = 2, vkd = 0;  // 128, 129, 130
  // Current loop, at once.
  std::int32_t qkp = 60, qki = 4, qkd = 0;  // 45, 46, 127

  // Motion, latched at GO. 16.16 counts per loop cycle (squared).
  std::int32_t vel = 7158282;          // 8
  std::int32_t acc = 14317;            // 9
  std::int32_t dec = 14317;            // 10; 0: as ACC
  std::int32_t ajerk = 0, djerk = 0;   // 11, 12: 0..1000, Bezier
  std::int32_t pro = 0;                // 13: 0 trapezoid, 1 spline, 2 Bezier, 3 PVT
  std::int32_t itime = 200;            // 7, loop cycles between two PVT points
  std::int32_t wmark = 10;             // 126
  std::int32_t hmask = 0, invert = 0;  // 48, 49
  std::int32_t hoffs = 0;              // 62

  // Interlocks.
  std::int32_t climit = 1500;              // 40, AD counts of TC
  std::int32_t ctime = 5000;               // 41, loop cycles; 0: off
  std::int32_t emask = 0;                  // 53, of digital_inputs()
  std::int32_t plimit = 0, ptime = 0;      // 109 AD counts, 110 ms; either 0: off
  std::int32_t elvolt = 0, ehvolt = 4095;  // 131, 132, AD counts
  std::int32_t ewposmin = INT32_MIN;       // 133
  std::int32_t ewposmax = INT32_MAX;       // 134
  std::int32_t eovs = INT32_MAX;           // 135, 16.16 counts per 100 us
  std::int32_t ewovs = INT32_MAX;          // 136, likewise
  std::int32_t eemp = 30;                  // 137
  std::int32_t eovtemp = 2000;             // 138, AD counts
  std::int32_t errmask = 0x1E380000;       // 139
  std::int32_t eovc = 4095;                // 143, AD counts of TC

  bool operator==(const Settings&) const = default;
};

/// Factory settings of axis 1 or 2: the address differs.
Settings factory_settings(int axis);

/// One of the parameters that SAVE keeps, with its name and id in Appendix A.
struct SavedSetting {
  std::string_view name;
  int id;
  std::int32_t Settings::* member;
};
/// PORIGIN is among them: it is restored with an absolute encoder only.
std::span<const SavedSetting> saved_settings();

/// The saved set of one axis as a block of bytes, with a check over it.
std::vector<std::uint8_t> pack(const Settings& settings);
/// Puts a packed set into settings; false, and nothing changed, if the block is damaged.
bool unpack(std::span<const std::uint8_t> block, Settings& settings);

}  // namespace virtdrive::rzt1
