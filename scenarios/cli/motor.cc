#include <fmt/format.h>

#include "plant/motor_library.h"
#include "scenarios/cli/commands.h"
#include "scenarios/motor_sheet.h"
#include "scenarios/output_file.h"
#include "scenarios/report/motor_page.h"

namespace virtdrive {

int motor(const MotorOptions& options) {
  if (options.schema) {
    fmt::print("{}", motor_schema());
    return kExitOk;
  }
  if (options.keys) {
    fmt::print("{}", motor_key_table());
    return kExitOk;
  }
  if (options.motor.empty()) {
    throw SetupError("motor: expected a name ('virtdrive list motors') or a file's path");
  }
  const Motor motor = find_motor(options.motor);
  if (!options.plot.empty()) {
    OutputFile file("--plot", options.plot);
    file.write(motor_svg(motor));
    file.close();
  }
  if (options.check) {
    fmt::print("{}: good\n", options.motor);
  } else if (options.json) {
    fmt::print("{}", motor_json(motor));
  } else if (options.plot.empty()) {
    fmt::print("{}", motor_text(motor));
  }
  return kExitOk;
}

}  // namespace virtdrive
