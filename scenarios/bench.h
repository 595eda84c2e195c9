// A test bench in virtual time: drives with their motors and loads, the serial lines between them
// and their hosts, and everything on it by name.
//
//   Bench bench({.drives = {{.kind = "toshiba-mcu", .load = "brake:20mNm@2s"}}});
//   bench.host()->start_motor(1, 2000);
//   bench.run_until(kSimStart + 3s, [&] { return bench.read("motor1.speed") > 1900; });
//   bench.set("supply1.voltage", 18);
//   bench.drive().power_off();
//
// It knows no file descriptor and no wall clock: an endpoint for each line and a runner (pty/) join
// it to the world. Two benches in one process share nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/event_loop.h"
#include "core/random.h"
#include "core/signals.h"
#include "devices/slcan/adapter.h"
#include "pty/can_bus.h"
#include "pty/serial_line.h"
#include "scenarios/bench_drive.h"
#include "scenarios/host_client.h"

namespace virtdrive {

struct LineSpec {
  std::string name = "line";
  LineTiming timing = LineTiming::kReal;
  std::optional<int> baud;       // none: the default of the first drive on it
  std::optional<Duplex> duplex;  // none: as the first drive on it has it
  bool echo = false;             // half duplex: the host hears itself
};

/// A DC supply that drives share, with the capacitors of all of them.
struct SupplySpec {
  std::string name;
  DcLinkParameters link{};
};

struct BenchOptions {
  std::vector<DriveSpec> drives;  // at least one
  std::vector<LineSpec> lines = {LineSpec{}};
  std::vector<SupplySpec> supplies;  // for drives that share one
  std::uint64_t seed = 1;
  Integrator integrator = Integrator::kDefault;
  /// Frames as a drive hears and says them; the drive's name comes first.
  std::function<void(std::string_view drive, const WireEvent&)> listener;
  NoteListener notes;
};

class Bench {
 public:
  /// SetupError for anything in the options that does not exist or is out of range.
  explicit Bench(const BenchOptions& options);
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  EventLoop& loop() { return loop_; }
  std::uint64_t seed() const { return seed_.value(); }

  /// The first one, or by its name; SetupError for an unknown name.
  BenchDrive& drive() { return *drives_.front(); }
  BenchDrive& drive(std::string_view name);
  SerialLine& line() { return lines_.front()->line; }
  SerialLine& line(std::string_view name);
  std::string_view line_name(const SerialLine& line) const;
  /// What is spoken on a line, for framers.
  std::string_view protocol_of(std::string_view line) const;
  const std::vector<std::unique_ptr<BenchDrive>>& drives() const { return drives_; }

  /// Every signal, input and fault.
  const Registry& registry() const { return registry_; }
  double read(std::string_view signal) const { return registry_.signal(signal).read(); }
  void set(std::string_view input, double value) const { registry_.set(input, value); }

  void run_until(SimTime t) { loop_.run_until(t); }
  void run_for(SimDuration duration) { loop_.run_until(loop_.now() + duration); }
  /// True as soon as the condition is; false when it never was until `limit`.
  bool run_until(SimTime limit, const std::function<bool()>& condition) {
    return loop_.run_until(limit, condition);
  }

  /// A host program inside the simulation, at the host end of the drive's line, in the words of the
  /// drive's protocol. Simulated time passes while it waits for an answer. It takes the host end
  /// from who had it and gives it back when it is destroyed: the last one first.
  std::unique_ptr<HostClient> host() { return host(drive()); }
  std::unique_ptr<HostClient> host(BenchDrive& drive);

 private:
  // A line to a CAN adapter, with the bus behind it.
  struct CanSide {
    CanSide(EventLoop& loop, SerialLine& line)
        : bus(loop), node(bus.add_node()), adapter(loop, line.add_device(), node) {}
    CanBus bus;
    CanNode& node;
    slcan::Adapter adapter;
  };
  struct NamedLine {
    NamedLine(EventLoop& loop, std::string its_name, const LineSettings& settings,
              LineOptions options)
        : name(std::move(its_name)), line(loop, settings, std::move(options)) {}
    std::string name;
    SerialLine line;
    std::optional<CanSide> can;
  };

  struct NamedSupply {
    std::string name;
    DcBus bus;
  };

  void add_line(const LineSpec& spec, const BenchOptions& options);
  void add_supply(const SupplySpec& spec, Integrator integrator);
  std::optional<DcBus> supply_of(const DriveSpec& spec);
  void add_drive(const DriveSpec& spec, const BenchOptions& options);
  std::vector<SerialLine*> lines_of(const DriveSpec& spec, const BenchOptions& options);
  CanBus* can_of(const DriveSpec& spec, const BenchOptions& options);
  NamedLine& named_line(std::string_view name) const;

  Seed seed_;
  EventLoop loop_;
  std::vector<std::unique_ptr<NamedLine>> lines_;
  std::vector<std::unique_ptr<NamedSupply>> supplies_;
  std::vector<std::unique_ptr<BenchDrive>> drives_;
  Registry registry_;
};

}  // namespace virtdrive
