// The names of everything that can be watched or moved from outside: recordings, scenarios and the
// status line know a bench only through this registry.
//
// A signal is read ("motor0.speed", rpm). An input is also written ("load0.brake_torque", Nm). A
// fault is an input that is 0 while all is well ("motor0.phase_a_open"). A name is
// component.quantity; the component carries the channel's number, and the drive's name goes before
// it where a bench has several ("left.motor0.speed").
#pragma once

#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace virtdrive {

struct Signal {
  std::string name;
  std::string unit;  // as printed: "rpm", "A", "" for none
  std::string doc;   // one line
  std::function<double()> read;
  /// Where the value is one of a few: their names, from 0 on; with `bits` those of its bits.
  std::vector<std::string_view> words = {};
  bool bits = false;
};

struct Input {
  Signal signal{};
  double minimum = -std::numeric_limits<double>::infinity();
  double maximum = std::numeric_limits<double>::infinity();
  std::function<void(double)> write = {};
  bool fault = false;
};

class Registry {
 public:
  /// From now on `scope` and a dot go before what is added; empty: nothing does.
  void set_scope(std::string_view scope);
  void add(Signal signal);
  void add(Input input);

  /// Signals and inputs in order of registration.
  const std::vector<Signal>& signals() const { return signals_; }
  const std::vector<Input>& inputs() const { return inputs_; }

  /// Looks a signal (or an input's present value) up; SetupError with the nearest names if unknown.
  const Signal& signal(std::string_view name) const;
  const Input& input(std::string_view name) const;

  /// Writes an input; SetupError if the name is unknown or the value out of its range.
  void set(std::string_view input, double value) const;

  /// Makes a fault be there, `severity` strong: 1 for those that are there or not. SetupError if
  /// the name is no fault's or the severity outside of its range.
  void inject(std::string_view fault, double severity = 1) const;
  void clear(std::string_view fault) const;
  /// Makes every fault go.
  void clear_faults() const;

 private:
  const Input& fault(std::string_view name) const;

  std::string prefix_;
  std::vector<Signal> signals_;
  std::vector<Input> inputs_;
};

}  // namespace virtdrive
