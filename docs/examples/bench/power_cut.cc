// A bench in C++: is a setting still there when the power goes right after it was stored?
//
// Built and run by the tests (tests/scenarios/CMakeLists.txt). All of it takes virtual time only.
#include <chrono>
#include <cstdio>

#include "scenarios/bench.h"

int main() {
  using namespace std::chrono_literals;
  virtdrive::Bench bench(
      {.drives = {{.kind = "toshiba-mcu", .load = "inertia:500gcm2"}}, .seed = 7});
  const auto host = bench.host();

  host->set("1.MaxAngAcc=800");
  host->call("StoreParameters", {1});
  host->start_motor(1, 1500);
  const auto fast = [&] { return bench.read("motor1.speed") > 1400; };
  if (!bench.run_until(bench.loop().now() + 10s, fast)) return 1;

  bench.drive().power_off();
  bench.run_for(200ms);
  std::printf("without power, after 0.2 s: %.0f rpm\n", bench.read("motor1.speed"));
  bench.drive().power_on();

  const double kept = host->get("1.MaxAngAcc").value;
  std::printf("MaxAngAcc after the power cut: %.0f\n", kept);
  return kept == 800 ? 0 : 1;
}
