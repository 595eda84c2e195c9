#include "core/signals.h"

#include <algorithm>

#include "core/check.h"
#include "core/names.h"

namespace virtdrive {
namespace {

std::vector<std::string_view> names_of(const std::vector<Signal>& signals) {
  std::vector<std::string_view> names;
  for (const Signal& signal : signals) names.push_back(signal.name);
  return names;
}

std::vector<std::string_view> names_of(const std::vector<Input>& inputs) {
  std::vector<std::string_view> names;
  for (const Input& input : inputs) names.push_back(input.signal.name);
  return names;
}

}  // namespace

void Registry::set_scope(std::string_view scope) {
  prefix_ = scope.empty() ? "" : fmt::format("{}.", scope);
}

void Registry::add(Signal signal) {
  signal.name.insert(0, prefix_);
  VIRTDRIVE_CHECK(std::ranges::find(signals_, signal.name, &Signal::name) == signals_.end(),
                  "signal {} registered twice", signal.name);
  signals_.push_back(std::move(signal));
}

void Registry::add(Input input) {
  add(input.signal);
  input.signal.name.insert(0, prefix_);
  inputs_.push_back(std::move(input));
}

const Signal& Registry::signal(std::string_view name) const {
  const auto it = std::ranges::find(signals_, name, &Signal::name);
  if (it == signals_.end()) throw SetupError(unknown_name("signal", name, names_of(signals_)));
  return *it;
}

const Input& Registry::input(std::string_view name) const {
  const auto it = std::ranges::find(inputs_, name, [](const Input& i) { return i.signal.name; });
  if (it == inputs_.end()) throw SetupError(unknown_name("input", name, names_of(inputs_)));
  return *it;
}

void Registry::set(std::string_view name, double value) const {
  const Input& input = this->input(name);
  if (!(value >= input.minimum && value <= input.maximum)) {
    throw SetupError(fmt::format("{} = {} {}: outside of {} ... {}", name, value, input.signal.unit,
                                 input.minimum, input.maximum));
  }
  input.write(value);
}

const Input& Registry::fault(std::string_view name) const {
  std::vector<std::string_view> names;
  for (const Input& input : inputs_) {
    if (!input.fault) continue;
    if (input.signal.name == name) return input;
    names.push_back(input.signal.name);
  }
  throw SetupError(unknown_name("fault", name, names));
}

void Registry::inject(std::string_view name, double severity) const {
  set(fault(name).signal.name, severity);
}

void Registry::clear(std::string_view name) const {
  fault(name).write(0);
}

void Registry::clear_faults() const {
  for (const Input& input : inputs_) {
    if (input.fault) input.write(0);
  }
}

}  // namespace virtdrive
