#include "devices/rzt1/variables.h"

#include <array>
#include <type_traits>
#include <variant>

#include "core/check.h"
#include "devices/protocol/binding.h"

namespace virtdrive::rzt1 {
namespace {

using S = Settings;
using Setting = std::int32_t Settings::*;

/// A variable with code behind it. Without `write`: it is read-only, or a write changes nothing.
struct Register {
  Reading (*read)(ServoDrive& servo, std::size_t axis);
  Result (*write)(ServoDrive& servo, std::size_t axis, std::int32_t value) = nullptr;
};

using Target = std::variant<Setting, Register>;

// A number that an axis tells.
template <auto kTell>
constexpr Register told() {
  return {[](ServoDrive& servo, std::size_t axis) -> Reading {
    return std::int64_t{(servo.axis(axis).*kTell)()};
  }};
}
// One that it takes.
template <auto kTake>
Result taken(ServoDrive& servo, std::size_t axis, std::int32_t value) {
  ServoAxis& its = servo.axis(axis);
  if constexpr (std::is_void_v<decltype((its.*kTake)(value))>) {
    (its.*kTake)(value);
    return Result::kOk;
  } else {
    return (its.*kTake)(value);
  }
}
template <auto kTell, auto kTake>
constexpr Register kept() {
  return {told<kTell>().read, &taken<kTake>};
}

template <std::size_t kChannel>
constexpr Register current() {
  return {[](ServoDrive& servo, std::size_t axis) -> Reading {
    return servo.axis(axis).raw_current(kChannel);
  }};
}
template <std::size_t kPhase>
constexpr Register phase() {
  return {[](ServoDrive& servo, std::size_t axis) -> Reading {
            return servo.axis(axis).phase_output(kPhase);
          },
          [](ServoDrive& servo, std::size_t axis, std::int32_t value) {
            return servo.axis(axis).set_phase_output(kPhase, value);
          }};
}
template <std::int32_t ErrorLatch::* kMember>
constexpr Register latched() {
  return {[](ServoDrive& servo, std::size_t axis) -> Reading {
            return servo.axis(axis).latched().*kMember;
          },
          [](ServoDrive& servo, std::size_t axis, std::int32_t value) {
            ErrorLatch latch = servo.axis(axis).latched();
            latch.*kMember = value;
            servo.axis(axis).set_latched(latch);
            return Result::kOk;
          }};
}
template <std::size_t kNumber>
constexpr Register output() {
  return {[](ServoDrive& servo, std::size_t) -> Reading { return servo.output(kNumber) ? 1 : 0; },
          [](ServoDrive& servo, std::size_t, std::int32_t value) {
            servo.set_output(kNumber, value != 0);
            return Result::kOk;
          }};
}
template <std::size_t kChannel>
constexpr Register trace_channel() {
  return {
      [](ServoDrive& servo, std::size_t) -> Reading { return servo.recorder().channel(kChannel); },
      [](ServoDrive& servo, std::size_t axis, std::int32_t value) {
        return servo.recorder().set_channel(kChannel, value, axis);
      }};
}

constexpr Register kTrigger = {
    [](ServoDrive& servo, std::size_t) -> Reading { return servo.recorder().trigger(); },
    [](ServoDrive& servo, std::size_t, std::int32_t value) { return servo.set_trigger(value); }};
// The recorder's own state: a host can stop it, TRACE starts it.
constexpr Register kTraceMode = {[](ServoDrive& servo, std::size_t) -> Reading {
                                   return static_cast<std::int64_t>(servo.recorder().mode());
                                 },
                                 [](ServoDrive& servo, std::size_t, std::int32_t value) {
                                   return value == 0 ? servo.set_trigger(0) : Result::kOk;
                                 }};
constexpr Register kTraceRate = {
    [](ServoDrive& servo, std::size_t) -> Reading { return servo.recorder().rate(); },
    [](ServoDrive& servo, std::size_t, std::int32_t value) {
      servo.recorder().set_rate(value);
      return Result::kOk;
    }};
constexpr Register kTraceLevel = {
    [](ServoDrive& servo, std::size_t) -> Reading { return servo.recorder().level(); },
    [](ServoDrive& servo, std::size_t, std::int32_t value) {
      servo.recorder().set_level(value);
      return Result::kOk;
    }};
constexpr Register kTimer = {
    [](ServoDrive& servo, std::size_t) -> Reading { return servo.timer(); }};
constexpr Register kInputs = {
    [](ServoDrive& servo, std::size_t) -> Reading { return servo.inputs(); }};
constexpr Register kTraceSizeRegister = {
    [](ServoDrive&, std::size_t) -> Reading { return std::int64_t{Recorder::kCapacity}; }};
constexpr Register kVersionRegister = {[](ServoDrive&, std::size_t) -> Reading {
  std::int64_t number = 0;
  for (std::size_t i = 4; i-- > 0;) number = number << 8 | kVersionNumbers[i];
  return number;
}};
constexpr Register kPvtPosition = {[](ServoDrive& servo, std::size_t axis) -> Reading {
                                     return servo.axis(axis).pending_pvt().position;
                                   },
                                   &taken<&ServoAxis::set_pvt_position>};
constexpr Register kPvtVelocity = {[](ServoDrive& servo, std::size_t axis) -> Reading {
                                     return servo.axis(axis).pending_pvt().velocity;
                                   },
                                   &taken<&ServoAxis::push_pvt_velocity>};
constexpr Register kEncoderWord = {
    [](ServoDrive& servo, std::size_t axis) -> Reading {
      std::uint16_t word = 0;
      const Result result = servo.axis(axis).read_encoder_word(word);
      if (result != Result::kOk) return status_of(result);
      return static_cast<std::int16_t>(word);
    },
    [](ServoDrive& servo, std::size_t axis, std::int32_t value) {
      return servo.axis(axis).write_encoder_word(static_cast<std::uint16_t>(value));
    }};

using A = ServoAxis;

constexpr auto kTargets = std::to_array<protocol::Binding<Target>>({
    {0, told<&A::status>()},
    {1, told<&A::position_error>()},
    {2, current<0>()},
    {3, current<1>()},
    {4, told<&A::total_current>()},
    {5, told<&A::velocity_counts>()},
    {6, told<&A::pvt_depth>()},
    {7, &S::itime},
    {8, &S::vel},
    {9, &S::acc},
    {10, &S::dec},
    {11, &S::ajerk},
    {12, &S::djerk},
    {13, &S::pro},
    {14, &S::kp},
    {15, &S::ki},
    {16, &S::kd},
    {17, &S::il},
    {18, &S::vff},
    {19, &S::aff},
    {20, &S::max_error},
    {21, &S::etime},
    {22, &S::ds},
    {23, &S::mlimit},
    {24, &S::bias},
    {25, &S::astop},
    {26, &S::pimode},
    {27, &S::pitime},
    {28, &S::piout},
    {29, &S::pmap},
    {30, kept<&A::phase_origin, &A::set_phase_origin>()},
    {31, &S::pcmode},
    {32, &S::pvector},
    {33, &S::pole_pairs},
    {34, &S::pcounts},
    {35, &S::ecpr},
    {36, &S::pioffs},
    {37, told<&A::phase_angle>()},
    {38, &S::padv},
    {39, &S::vcomp},
    {40, &S::climit},
    {41, &S::ctime},
    {42, told<&A::direct_current>()},
    {43, told<&A::quadrature_current>()},
    {44, told<&A::quadrature_error>()},
    {45, &S::qkp},
    {46, &S::qki},
    {47, &S::pct},
    {48, &S::hmask},
    {49, &S::invert},
    {50, &S::hinvert},
    {51, &S::hshift},
    {52, kept<&A::hall_position, &A::set_hall_position>()},
    {53, &S::emask},
    {54, latched<&ErrorLatch::command_position>()},
    {55, latched<&ErrorLatch::command_velocity>()},
    {56, latched<&ErrorLatch::position>()},
    {57, phase<0>()},
    {58, phase<1>()},
    {59, phase<2>()},
    {60, &S::type},
    {61, &S::htype},
    {62, &S::hoffs},
    {63, &S::data0},
    {64, &S::data1},
    {65, &S::data2},
    {66, &S::data3},
    {67, &S::data4},
    {68, &S::data5},
    {69, &S::data6},
    {70, &S::data7},
    {71, &S::phases},
    {72, &S::brake},
    {73, kTraceMode},
    {74, kTraceRate},
    {75, kTraceLevel},
    {76, &S::sim},
    {77, kTimer},
    {78, kPvtPosition},
    {79, kPvtVelocity},
    {80, kept<&A::target, &A::set_target>()},
    {81, kept<&A::distance, &A::set_distance>()},
    {82, kept<&A::position, &A::set_position>()},
    {83, kInputs},
    {84, told<&A::take_index>()},
    {97, kVersionRegister},
    {98, output<0>()},
    {99, output<1>()},
    {100, kept<&A::output, &A::set_output>()},
    {101, kept<&A::output, &A::set_output>()},
    {102, kept<&A::output_d, &A::set_output_d>()},
    {103, trace_channel<0>()},
    {104, trace_channel<1>()},
    {105, trace_channel<2>()},
    {106, trace_channel<3>()},
    {107, kTrigger},
    {109, &S::plimit},
    {110, &S::ptime},
    {111, &S::gear_in},
    {112, &S::gear_out},
    {114, &S::pinvert},
    {117, &S::etype},
    {118, told<&A::encoder_id>()},
    {119, &S::eaddr},
    {120, kEncoderWord},
    {121, &S::ebaudrate},
    {122, told<&A::encoder_status>()},
    {123, &S::address},
    {124, &S::group},
    {125, kTraceSizeRegister},
    {126, &S::wmark},
    {127, &S::qkd},
    {128, &S::vkp},
    {129, &S::vki},
    {130, &S::vkd},
    {131, &S::elvolt},
    {132, &S::ehvolt},
    {133, &S::ewposmin},
    {134, &S::ewposmax},
    {135, &S::eovs},
    {136, &S::ewovs},
    {137, &S::eemp},
    {138, &S::eovtemp},
    {139, &S::errmask},
    {140, told<&A::bus_counts>()},
    {141, told<&A::errors>()},
    {143, &S::eovc},
    {144, told<&A::temperature_counts>()},
});
static_assert(protocol::covers(kTable.parameters, kTargets),
              "a variable that is not rejected has nothing behind it, or the reverse");

using Call = Result (*)(ServoAxis&);

template <auto kDo>
constexpr Call call_of() {
  return [](ServoAxis& axis) { return (axis.*kDo)(); };
}

// Null: the device's.
constexpr auto kCalls = std::to_array<protocol::Binding<Call>>({
    {85, call_of<&A::go>()},
    {86, call_of<&A::forward>()},
    {87, call_of<&A::reverse>()},
    {88, nullptr},
    {89, call_of<&A::on>()},
    {90, call_of<&A::off>()},
    {91, call_of<&A::enable>()},
    {92, call_of<&A::disable>()},
    {93, call_of<&A::stop>()},
    {94, call_of<&A::abort>()},
    {95, call_of<&A::home>()},
    {96, call_of<&A::align>()},
    {108, nullptr},
    {113, call_of<&A::setup>()},
    {115, nullptr},
    {116, nullptr},
    {142,
     [](ServoAxis& axis) {
       axis.reset_errors();
       return Result::kOk;
     }},
});
static_assert(protocol::covers(kTable.functions, kCalls),
              "a function that is not rejected has nothing behind it, or the reverse");

// As it is on the wire: of the unsigned ones of four bytes an int32 holds the bits.
std::int64_t on_wire(const ParameterRow& row, std::int64_t value) {
  return row.type == WireType::kU32 ? static_cast<std::uint32_t>(value) : value;
}

}  // namespace

Reading Variables::read(std::size_t axis, const ParameterRow& row) {
  const Target* const target = protocol::find(kTargets, row.id);
  VIRTDRIVE_CHECK(target != nullptr, "nothing behind {}", row.name);
  if (const Setting* const setting = std::get_if<Setting>(target)) {
    return on_wire(row, servo_.axis(axis).settings().**setting);
  }
  Reading reading = std::get<Register>(*target).read(servo_, axis);
  reading.value = on_wire(row, reading.value);
  return reading;
}

Status Variables::write(std::size_t axis, const ParameterRow& row, std::int64_t value) {
  const protocol::Refusal refusal = protocol::check_write(&row, value);
  if (refusal != protocol::Refusal::kNone) return status_of(refusal);
  const Target* const target = protocol::find(kTargets, row.id);
  VIRTDRIVE_CHECK(target != nullptr, "nothing behind {}", row.name);
  const auto number = static_cast<std::int32_t>(value);
  if (const Setting* const setting = std::get_if<Setting>(target)) {
    return status_of(servo_.axis(axis).set(*setting, number));
  }
  const Register& its = std::get<Register>(*target);
  return its.write != nullptr ? status_of(its.write(servo_, axis, number)) : Status::kOk;
}

bool Variables::has_call(std::uint16_t id) const {
  const Call* const call = protocol::find(kCalls, id);
  return call != nullptr && *call != nullptr;
}

Status Variables::call(std::size_t axis, std::uint16_t id) {
  const Call* const call = protocol::find(kCalls, id);
  VIRTDRIVE_CHECK(call != nullptr && *call != nullptr, "function {} is not an axis'", id);
  return status_of((*call)(servo_.axis(axis)));
}

}  // namespace virtdrive::rzt1
