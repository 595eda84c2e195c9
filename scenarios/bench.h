// A test bench: one drive with its motors, loads and supplies, on one serial line, in virtual time.
//
//   Bench bench({.drive = "toshiba-mcu", .load = "brake:20mNm@2s"});
//   bench.loop().run_until(kSimStart + 3s);
//   bench.registry().signal("motor1.speed").read();
//
// It knows no file descriptor and no wall clock: an endpoint and a runner (pty/) join it to the
// world. Two benches in one process share nothing.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/event_loop.h"
#include "core/random.h"
#include "core/signals.h"
#include "pty/serial_line.h"
#include "scenarios/drive.h"
#include "scenarios/load_spec.h"

namespace virtdrive {

struct BenchOptions {
  std::string drive;
  std::string motor;  // a name or a file's path; empty: the drive's default
  std::string load = "none";
  LineTiming line = LineTiming::kReal;
  std::optional<int> baud;  // none: the drive's default
  std::uint64_t seed = 1;
  Integrator integrator = Integrator::kDefault;
  bool lenient = false;
  std::vector<std::string> set;  // "NAME=VALUE"
  std::string nvm;               // file of the drive's non-volatile memory; empty: none is kept
  WireListener listener;
  NoteListener notes;
};

class Bench {
 public:
  /// SetupError for anything in the options that does not exist or is out of range.
  explicit Bench(const BenchOptions& options);
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  EventLoop& loop() { return loop_; }
  SerialLine& line() { return line_; }
  Drive& drive() { return *drive_; }
  const Registry& registry() const { return registry_; }
  const DriveKind& kind() const { return kind_; }
  const Motor& motor() const { return motor_; }
  std::uint64_t seed() const { return seed_.value(); }

 private:
  void register_plant(std::size_t channel);
  void apply_due_load_steps();

  const DriveKind& kind_;
  const Motor motor_;
  Seed seed_;
  EventLoop loop_;
  SerialLine line_;
  std::unique_ptr<NonVolatileMemory> memory_;
  std::unique_ptr<Drive> drive_;
  Registry registry_;
  std::vector<LoadStep> load_steps_;
  std::size_t next_load_step_ = 0;
  Wakeup load_step_;
};

}  // namespace virtdrive
