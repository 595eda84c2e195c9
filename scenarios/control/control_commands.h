// What can be asked of a bench while it runs: JSON in, JSON out, a line each.
//
//   {"do": "read", "name": "motor1.speed"}      {"ok": true, "time_s": 2.4, "value": 1999.2, ...}
//   {"do": "inject", "name": "line.to_host_cut"}
//   {"do": "rate", "value": 0}                   stand still
//
// A request is answered at the simulated instant at which it came. An "id" comes back as it was.
// docs/control.md has them all.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "pty/runner.h"
#include "scenarios/bench.h"

namespace virtdrive {

class ControlCommands {
 public:
  /// Both must outlive it.
  ControlCommands(Bench& bench, Runner& runner) : bench_(bench), runner_(runner) {}

  /// Carries a request out and returns its answer, without a line's end. Never throws for what is
  /// asked: {"ok": false, "error": ...}.
  std::string answer(std::string_view request);

  /// The words for "do".
  static std::vector<std::string_view> words();

 private:
  Bench& bench_;
  Runner& runner_;
};

}  // namespace virtdrive
