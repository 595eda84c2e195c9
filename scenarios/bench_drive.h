// A drive at its place on a bench: the controller with its power and its non-volatile memory, its
// end of a line, and the motor and load on each of its shafts.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/event_loop.h"
#include "core/signals.h"
#include "pty/serial_line.h"
#include "scenarios/drive.h"
#include "scenarios/load_spec.h"
#include "scenarios/memory_faults.h"

namespace virtdrive {

struct DriveSpec {
  std::string kind;  // see drive_catalogue()
  std::string name;  // goes before its signals' names; only one drive of a bench needs none
  std::string line;  // of its first port; empty: the bench's first
  std::vector<std::string> other_lines;  // of its further ports; empty, or missing: no line
  std::vector<std::string>
      motors;  // names or files; one for all channels or one each; empty: the kind's default
  std::string supply;            // one of the bench's; empty: what the kind of drive hangs on
  std::string load = "none";     // see parse_load()
  std::vector<std::string> set;  // "[CHANNEL.]NAME=VALUE[UNIT]", written at the start
  std::string nvm;               // file of the non-volatile memory; empty: kept in the process
  bool lenient = false;
};

class BenchDrive {
 public:
  /// What all drives of a bench share.
  struct Surroundings {
    EventLoop& loop;
    std::vector<SerialLine*> lines;  // one a port of the drive; null where none is
    CanBus* can;                     // null where none is
    std::optional<DcBus> supply;
    const Seed& seed;
    Integrator integrator;
    WireListener listener;
    NoteListener notes;
  };

  /// SetupError for anything in `spec` that does not exist or is out of range.
  BenchDrive(const DriveSpec& spec, const Surroundings& bench);
  BenchDrive(const BenchDrive&) = delete;
  BenchDrive& operator=(const BenchDrive&) = delete;

  const std::string& name() const { return name_; }
  const DriveKind& kind() const { return kind_; }
  const Motor& motor(std::size_t channel) const { return motors_[channel]; }
  std::size_t channels() const { return motors_.size(); }
  /// Of its first port.
  SerialLine& line() { return *lines_.front(); }
  /// Of any port; null where none is, and at a CAN port.
  SerialLine* line(std::size_t port) { return lines_[port]; }
  Drive& controller() { return *drive_; }

  /// Takes the drive's supply away: its gates are off, its program is gone, what it was sending is
  /// cut off; its rotors turn on. What it had stored is there again at power_on().
  void power_off();
  void power_on();
  bool powered() const { return powered_; }
  /// The controller starts anew; the supply stays.
  void reset();

  /// Adds the plant's signals and inputs, and the drive's own.
  void register_signals(Registry& registry);

 private:
  std::unique_ptr<Drive> make_drive(const DriveSpec& spec, const Surroundings& bench);
  void attach();
  void write(const std::string& assignment);
  void apply_due_load_steps();

  std::string name_;
  const DriveKind& kind_;
  EventLoop& loop_;
  std::vector<SerialLine*> lines_;
  std::vector<LineEnd*> line_ends_;
  Seed seed_;
  std::vector<Motor> motors_;  // one a channel
  FaultyMemory memory_;
  std::unique_ptr<Drive> drive_;
  bool powered_ = true;
  std::vector<LoadStep> load_steps_;
  std::size_t next_load_step_ = 0;
  Wakeup load_step_;
};

}  // namespace virtdrive
