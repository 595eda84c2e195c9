#include "scenarios/scenario/player.h"

#include <algorithm>
#include <fmt/format.h>
#include <list>
#include <memory>

#include "core/check.h"
#include "scenarios/line_transport.h"
#include "scenarios/recording/sampler.h"
#include "scenarios/scenario/host_program.h"
#include "scenarios/scenario/quantity.h"
#include "scenarios/scenario/watcher.h"

namespace virtdrive {
namespace {

using namespace std::chrono_literals;

constexpr SimDuration kRampInterval = 1ms;
constexpr SimDuration kHeartbeat = 1ms;

std::string hex(std::span<const std::uint8_t> bytes) {
  return fmt::format("{:02x}", fmt::join(bytes, " "));
}

// A step went wrong; the player adds which.
struct Wrong {
  std::string expected;
  std::string got;
  std::string off = {};
};

// Something that goes on beside the steps.
struct Task {
  Wakeup wakeup;
  std::function<void(Task&)> run;
  std::string input;  // that it moves; "" for none
  bool done = false;
};

// A step that waits for its moment.
struct Armed {
  const Step* step;
  std::optional<LiveCondition> when;
  std::size_t frames = 0;
  bool seen = false;  // the moment has come; `after` runs
  bool fired = false;
  Wakeup wakeup;
};

void collect(const std::vector<Step>& steps, std::vector<std::string>& names) {
  const auto add = [&](const Condition& condition) {
    for (const std::string& name : condition.signals()) names.push_back(name);
  };
  const auto add_values = [&](const std::vector<NamedValue>& values) {
    for (const auto& [name, value] : values) names.push_back(name);
  };
  for (const Step& step : steps) {
    if (const auto* wait = std::get_if<WaitUntil>(&step.action)) add(wait->condition);
    if (const auto* expect = std::get_if<Expect>(&step.action)) add(expect->condition);
    if (const auto* watch = std::get_if<Watch>(&step.action)) add(watch->condition);
    if (const auto* apply = std::get_if<Apply>(&step.action)) add_values(apply->inputs);
    if (const auto* ramp = std::get_if<Ramp>(&step.action)) add_values(ramp->targets);
    if (const auto* profile = std::get_if<Profile>(&step.action)) names.push_back(profile->input);
    if (const auto* repeat = std::get_if<Repeat>(&step.action)) collect(repeat->steps, names);
    if (step.trigger && step.trigger->when) add(*step.trigger->when);
  }
}

class Player {
 public:
  Player(const Scenario& scenario, std::uint64_t seed);

  ScenarioResult play();

 private:
  void run_steps(const std::vector<Step>& steps, int depth);
  void end_watches(const Step* at);
  void run_step(const Step& step, int depth);
  void arm(const Step& step);
  void fire(Armed& armed);
  void perform(const Action& action, const std::string& text);

  void run(const StartMotor& start);
  void run(const StopMotor& stop);
  void run(const SetParameters& set);
  void run(const ReadParameter& read);
  void run(const CallCommand& call);
  void run(const SendRaw& raw);
  void run(const WaitFor& wait);
  void run(const WaitUntil& wait);
  void run(const Expect& expect);
  void run(const Watch& watch);
  void run(const Apply& apply);
  void run(const Ramp& ramp);
  void run(const Profile& profile);
  void run(const Inject& inject);
  void run(const Clear& clear);
  void run(const Power& power);
  void run(const Reset& reset);
  void run(const Note& note);
  void run(const RunHost& host);
  void run(const Repeat& repeat);

  BenchOptions options_with_listeners(std::uint64_t seed);
  std::unique_ptr<Sampler> make_sampler();
  void on_frame(std::string_view drive, const WireEvent& event);
  void count_milestone(Armed& armed, std::string_view drive, const WireEvent& event);
  void tell(std::string text);
  void judge(const ExpectedReply& expected, const std::function<void()>& ask);
  void switch_power(const std::string& drive, bool on);
  void move(const std::string& input, std::vector<Profile::Point> points, bool linear,
            std::size_t repeat, bool background);
  void set_input(const std::string& input, double value);
  void leave_alone(const std::string& input);
  Task& later(SimDuration delay, std::function<void()> act);
  Task& start_task(std::function<void(Task&)> run, SimTime first);
  void forget_done_tasks();
  void let_pass(SimDuration time);
  bool let_pass_until(SimDuration limit, const std::function<bool()>& condition);
  [[noreturn]] void fail(const Step& step, const Wrong& wrong);

  const Scenario& scenario_;
  ScenarioResult result_;
  Bench bench_;
  EventLoop& loop_;
  std::list<Armed> armed_;
  Watcher watcher_;
  std::unique_ptr<Sampler> sampler_;
  std::vector<std::unique_ptr<Task>> tasks_;
  Wakeup heartbeat_;
  bool beating_ = false;

  const Step* step_ = nullptr;  // under way
  int depth_ = 0;
  std::string detail_;                       // what the step has to tell
  std::optional<Failure> violation_;         // of a watch
  const std::vector<Step>* list_ = nullptr;  // the step is one of
  // A watch, which ends when a step of its list begins, or with the list.
  struct Ending {
    const std::vector<Step>* list;
    const Step* step;  // null: the end
    Watcher::Id id;
    std::shared_ptr<bool> over;
  };
  std::vector<Ending> endings_;
};

struct Failed {};  // result_.failure is set

Player::Player(const Scenario& scenario, std::uint64_t seed)
    : scenario_(scenario),
      bench_(options_with_listeners(seed)),
      loop_(bench_.loop()),
      watcher_(loop_),
      sampler_(make_sampler()),
      heartbeat_(loop_.add(Phase::kRecord, [this] {
        if (beating_) heartbeat_.at(loop_.now() + kHeartbeat);
      })) {
  result_.file = scenario.file;
  result_.name = scenario.name;
  result_.about = scenario.about;
  result_.source = scenario.source;
  result_.tags = scenario.tags;
  result_.seed = seed;
  for (const auto& drive : bench_.drives()) {
    result_.bench += fmt::format(
        "{}{}{}, motor {}, {} baud", result_.bench.empty() ? "" : "; ",
        drive->name().empty() ? "" : drive->name() + ": ", drive->kind().name,
        drive->motor(drive->kind().default_channel).name, drive->line().settings().baud);
  }
}

BenchOptions Player::options_with_listeners(std::uint64_t seed) {
  BenchOptions options = scenario_.bench;
  options.seed = seed;
  options.listener = [this](std::string_view drive, const WireEvent& event) {
    on_frame(drive, event);
  };
  options.notes = [this](std::string_view text) { result_.notes.emplace_back(text); };
  return options;
}

std::unique_ptr<Sampler> Player::make_sampler() {
  std::vector<std::string> wanted = scenario_.signals;
  const BenchDrive& drive = bench_.drive();
  const std::string scope = drive.name().empty() ? "" : drive.name() + ".";
  const std::size_t channel = drive.kind().default_channel;
  for (const std::string_view name :
       {"motor{}.speed", "motor{}.current_q", "motor{}.torque", "bus{}.voltage"}) {
    wanted.push_back(scope + fmt::format(fmt::runtime(name), channel));
  }
  collect(scenario_.steps, wanted);
  // In the registry's order, each once; with the states of the drive's channel.
  std::vector<std::string> names;
  std::vector<History::Column> columns;
  const std::string states = scope + fmt::format("drive{}.", channel);
  for (const Signal& signal : bench_.registry().signals()) {
    const bool state = !signal.words.empty() && signal.name.starts_with(states);
    if (!state && std::ranges::find(wanted, signal.name) == wanted.end()) continue;
    names.push_back(signal.name);
    columns.push_back({signal.name, signal.unit, signal.words, signal.bits});
  }
  result_.history = History(std::move(columns));
  return std::make_unique<Sampler>(
      loop_, bench_.registry(), names, scenario_.interval,
      [this](SimTime time, std::span<const double> values) { result_.history.add(time, values); });
}

ScenarioResult Player::play() {
  try {
    run_steps(scenario_.steps, 0);
    for (const Armed& armed : armed_) {
      if (!armed.fired) {
        step_ = armed.step;
        fail(*armed.step, {"its moment to come before the end of the scenario",
                           armed.seen ? "the end came first" : "it never came"});
      }
    }
  } catch (const Failed&) {
  } catch (const SetupError& error) {
    // What the bench cannot do though its names are right: this fault on this bridge.
    result_.failure = Failure{.place = place_text(scenario_, *step_),
                              .step = step_->text,
                              .expected = "a bench that can do so",
                              .got = error.what(),
                              .off = {},
                              .at = loop_.now()};
  }
  result_.simulated = loop_.now() - kSimStart;
  return std::move(result_);
}

void Player::run_steps(const std::vector<Step>& steps, int depth) {
  const auto* const outer = std::exchange(list_, &steps);
  for (const Step& step : steps) {
    end_watches(&step);
    run_step(step, depth);
    list_ = &steps;
  }
  end_watches(nullptr);
  list_ = outer;
}

void Player::end_watches(const Step* at) {
  std::erase_if(endings_, [&](const Ending& ending) {
    if (ending.list != list_ || ending.step != at) return false;
    if (!*ending.over) watcher_.remove(ending.id);
    return true;
  });
}

void Player::run_step(const Step& step, int depth) {
  forget_done_tasks();
  const SimTime begin = loop_.now();
  step_ = &step;
  depth_ = depth;
  detail_.clear();
  StepResult result{.text = step.text,
                    .label = step.label,
                    .line = step.place.line,
                    .depth = depth,
                    .begin = begin};
  const bool is_repeat = std::holds_alternative<Repeat>(step.action);
  if (is_repeat) result_.steps.add(result);  // its steps follow it
  try {
    if (step.trigger) {
      arm(step);
      result.status = StepResult::Status::kArmed;
    } else {
      std::visit([this](const auto& action) { run(action); }, step.action);
    }
    if (violation_) throw Failed{};
  } catch (const Wrong& wrong) {
    result.end = loop_.now();
    result.status = StepResult::Status::kFailed;
    result.detail = wrong.got;
    result_.steps.add(std::move(result));
    fail(step, wrong);
  } catch (const Failed&) {
    if (violation_) result_.failure = violation_;
    if (!is_repeat) {
      result.end = loop_.now();
      result.status = StepResult::Status::kFailed;
      result.detail = violation_ ? "a watch was violated" : "";
      result_.steps.add(std::move(result));
    }
    throw;
  }
  if (is_repeat) return;
  result.end = loop_.now();
  result.detail = std::move(detail_);
  result_.steps.add(std::move(result));
}

void Player::fail(const Step& step, const Wrong& wrong) {
  result_.failure = violation_ ? *violation_
                               : Failure{.place = place_text(scenario_, step),
                                         .step = step.text,
                                         .expected = wrong.expected,
                                         .got = wrong.got,
                                         .off = wrong.off,
                                         .at = loop_.now()};
  throw Failed{};
}

// --- Triggers ------------------------------------------------------------------------------------

void Player::arm(const Step& step) {
  const Trigger& trigger = *step.trigger;
  Armed& armed = armed_.emplace_back(Armed{.step = &step, .when = {}, .wakeup = {}});
  armed.wakeup = loop_.add(Phase::kScenario, [this, &armed] { fire(armed); });
  const auto come = [this, &armed, after = trigger.after] {
    armed.seen = true;
    armed.wakeup.at(loop_.now() + after);
  };
  if (trigger.when) armed.when.emplace(*trigger.when, bench_.registry());
  if (trigger.at) return;
  if (trigger.when)
    watcher_.add({.condition = *armed.when, .awaited = true, .then = come});
  else
    come();
}

void Player::count_milestone(Armed& armed, std::string_view drive, const WireEvent& event) {
  const auto& milestone = armed.step->trigger->at;
  if (!milestone || armed.seen || milestone->drive != drive) return;
  const auto kind = milestone->kind == Milestone::Kind::kRequest ? WireEvent::Kind::kRequest
                                                                 : WireEvent::Kind::kReply;
  if (event.kind != kind || event.text.substr(0, event.text.find(' ')) != milestone->frame) return;
  if (armed.when && !armed.when->met()) return;
  if (++armed.frames < milestone->number) return;
  armed.seen = true;
  // The drive is in the middle of its own work: what is done to it comes right after that.
  armed.wakeup.at(loop_.now() + armed.step->trigger->after);
}

void Player::fire(Armed& armed) {
  armed.fired = true;
  perform(armed.step->action, armed.step->text);
}

// What may be triggered never fails and never waits.
void Player::perform(const Action& action, const std::string& text) {
  if (const auto* apply = std::get_if<Apply>(&action)) return run(*apply);
  if (const auto* inject = std::get_if<Inject>(&action)) return run(*inject);
  if (const auto* clear = std::get_if<Clear>(&action)) return run(*clear);
  if (const auto* power = std::get_if<Power>(&action)) return run(*power);
  if (const auto* reset = std::get_if<Reset>(&action)) return run(*reset);
  if (const auto* ramp = std::get_if<Ramp>(&action)) {
    Ramp background = *ramp;
    background.background = true;
    return run(background);
  }
  if (const auto* profile = std::get_if<Profile>(&action)) {
    Profile background = *profile;
    background.background = true;
    return run(background);
  }
  tell(text);
}

void Player::on_frame(std::string_view drive, const WireEvent& event) {
  result_.frames.add(
      {event.time, std::string(drive), event.kind, hex(event.bytes), std::string(event.text)});
  for (Armed& armed : armed_) count_milestone(armed, drive, event);
}

void Player::tell(std::string text) {
  result_.events.add({loop_.now(), std::move(text)});
}

// --- Host steps ----------------------------------------------------------------------------------

void Player::judge(const ExpectedReply& expected, const std::function<void()>& ask) {
  using Kind = ExpectedReply::Kind;
  std::string got = "done";
  Kind kind = Kind::kDone;
  std::int64_t code = 0;
  try {
    ask();
  } catch (const DriveRefused& error) {
    kind = Kind::kError;
    code = error.code();
    got = error.what();
  } catch (const DriveSilent& error) {
    kind = Kind::kNone;
    got = error.what();
  } catch (const ClientError& error) {
    kind = Kind::kAnything;
    got = error.what();
  }
  if (violation_) throw Failed{};
  if (detail_.empty() && got != "done") detail_ = got;
  const bool good = expected.kind == Kind::kAnything || expected.kind == kind ||
                    (expected.kind == Kind::kCode && kind == Kind::kError && code == expected.code);
  if (!good) throw Wrong{fmt::format("reply {}", expected.text), got};
}

void Player::run(const StartMotor& start) {
  judge(start.reply,
        [&] { bench_.host(bench_.drive(start.drive))->start_motor(start.channel, start.rpm); });
}

void Player::run(const StopMotor& stop) {
  judge(stop.reply, [&] { bench_.host(bench_.drive(stop.drive))->stop_motor(stop.channel); });
}

void Player::run(const SetParameters& set) {
  const auto host = bench_.host(bench_.drive(set.drive));
  for (const std::string& assignment : set.assignments) {
    judge(set.reply, [&] { host->set(assignment); });
  }
}

void Player::run(const ReadParameter& read) {
  const auto host = bench_.host(bench_.drive(read.drive));
  const SimTime limit = loop_.now() + read.within;
  while (true) {
    std::optional<Reading> reading;
    judge(read.reply, [&] { reading = host->get(read.parameter); });
    if (!reading) return;
    detail_ = show_quantity(reading->value, reading->unit);
    if (!read.wanted) return;
    const auto value =
        read.unit.empty() ? reading->value : convert(reading->value, reading->unit, read.unit);
    if (value && read.wanted->holds(*value)) return;
    if (loop_.now() + read.every > limit) {
      throw Wrong{fmt::format("{} {}", read.parameter, read.wanted->text), detail_,
                  value ? read.wanted->shortfall(*value, read.unit) : ""};
    }
    let_pass(read.every);
  }
}

void Player::run(const CallCommand& call) {
  const auto host = bench_.host(bench_.drive(call.drive));
  protocol::Values reply;
  bool answered = false;
  judge(call.reply, [&] {
    reply = host->call(call.command, call.request);
    answered = true;
  });
  if (!answered) return;
  std::vector<Wrong> wrongs;
  for (const CallCommand::Field& field : call.fields) {
    if (field.index >= reply.size()) continue;
    const double value = static_cast<double>(reply[field.index]) * field.scale;
    const std::string shown = fmt::format("{} {}", field.name, show_quantity(value, field.unit));
    detail_ += fmt::format("{}{}", detail_.empty() ? "" : ", ", shown);
    if (field.wanted && !field.wanted->holds(value)) {
      wrongs.push_back({fmt::format("{} {}", field.name, field.wanted->text), shown,
                        field.wanted->shortfall(value, field.unit)});
    }
  }
  if (!wrongs.empty()) throw wrongs.front();
}

void Player::run(const SendRaw& raw) {
  LineTransport line(loop_, bench_.drive(raw.drive).line());
  for (const SendRaw::Part& part : raw.parts) {
    if (part.pause > SimDuration{}) let_pass(part.pause);
    line.write(part.bytes);
  }
  if (!raw.judged) return;
  std::vector<std::uint8_t> heard;
  const SimTime limit = loop_.now() + raw.within;
  const std::size_t wanted = std::max<std::size_t>(raw.reply.size(), 1);
  while (heard.size() < wanted && loop_.now() < limit) {
    const auto byte = line.read(limit - loop_.now());
    if (violation_) throw Failed{};
    if (!byte) break;
    heard.push_back(*byte);
  }
  detail_ = heard.empty() ? "silence" : hex(heard);
  std::string expected;
  bool good = heard.size() == raw.reply.size();
  std::size_t first_wrong = raw.reply.size();
  for (std::size_t i = 0; i < raw.reply.size(); ++i) {
    const auto& byte = raw.reply[i];
    expected += fmt::format("{}{}", i == 0 ? "" : " ", byte ? fmt::format("{:02x}", *byte) : "??");
    if (i < heard.size() && byte && heard[i] != *byte) {
      good = false;
      first_wrong = std::min(first_wrong, i);
    }
  }
  if (good) return;
  const bool bytes_differ = first_wrong < raw.reply.size();
  throw Wrong{raw.reply.empty() ? fmt::format("silence for {}", show_time(raw.within)) : expected,
              detail_,
              bytes_differ ? fmt::format("byte {} is the first that differs", first_wrong + 1)
              : raw.reply.empty() ? ""
                                  : fmt::format("{} of {} bytes within {}", heard.size(),
                                                raw.reply.size(), show_time(raw.within))};
}

// --- Time and conditions -------------------------------------------------------------------------

void Player::let_pass(SimDuration time) {
  loop_.run_until(loop_.now() + time);
  if (violation_) throw Failed{};
}

bool Player::let_pass_until(SimDuration limit, const std::function<bool()>& condition) {
  beating_ = true;  // a bench where nothing happens is looked at too
  heartbeat_.at(loop_.now());
  const bool met = loop_.run_until(loop_.now() + limit, condition);
  beating_ = false;
  heartbeat_.cancel();
  if (violation_) throw Failed{};
  return met;
}

void Player::run(const WaitFor& wait) {
  let_pass(wait.time);
}

void Player::run(const WaitUntil& wait) {
  const LiveCondition condition(wait.condition, bench_.registry());
  const SimTime begin = loop_.now();
  const bool met = let_pass_until(wait.within, [&] { return condition.met(); });
  detail_ = fmt::format("{} after {}", condition.values(), show_time(loop_.now() - begin));
  if (met) return;
  throw Wrong{fmt::format("{} within {}", condition.text(), show_time(wait.within)),
              condition.values(), condition.shortfall()};
}

void Player::run(const Expect& expect) {
  const LiveCondition condition(expect.condition, bench_.registry());
  const SimTime latest = loop_.now() + expect.within;  // for it to have come true
  std::optional<SimTime> since;
  std::string lost;  // how it last broke
  std::string lost_off;
  SimTime lost_at = kSimStart;
  const auto judged = [&] {
    if (!condition.met()) {
      lost = condition.values();
      lost_off = condition.shortfall();
      lost_at = loop_.now();
      since.reset();
      return loop_.now() >= latest;
    }
    if (!since) since = loop_.now();
    return loop_.now() - *since >= expect.hold || *since > latest;
  };
  let_pass_until(expect.within + expect.hold, judged);
  detail_ = condition.values();
  if (since && *since <= latest && loop_.now() - *since >= expect.hold) return;
  std::string expected = condition.text();
  if (expect.within > SimDuration{}) {
    expected += fmt::format(" within {}", show_time(expect.within));
  }
  if (expect.hold > SimDuration{}) expected += fmt::format(" for {}", show_time(expect.hold));
  throw Wrong{expected, fmt::format("{} at {}", lost, show_instant(lost_at)), lost_off};
}

void Player::run(const Watch& watch) {
  const auto over = std::make_shared<bool>(false);
  const LiveCondition condition(watch.condition, bench_.registry());
  const Step& step = *step_;
  const auto violated = [this, &step, condition, over] {
    *over = true;
    violation_ = Failure{.place = place_text(scenario_, step),
                         .step = step.text,
                         .expected = step.text,
                         .got = condition.values(),
                         .off = condition.shortfall(),
                         .at = loop_.now()};
    loop_.stop();
  };
  const auto id = watcher_.add({.condition = condition, .awaited = watch.never, .then = violated});
  endings_.push_back({list_, watch.until ? &(*list_)[*watch.until] : nullptr, id, over});
}

// --- The bench -----------------------------------------------------------------------------------

Task& Player::start_task(std::function<void(Task&)> run, SimTime first) {
  Task& task = *tasks_.emplace_back(std::make_unique<Task>());
  task.run = std::move(run);
  task.wakeup = loop_.add(Phase::kScenario, [&task] { task.run(task); });
  task.wakeup.at(first);
  return task;
}

void Player::forget_done_tasks() {
  std::erase_if(tasks_, [](const auto& task) { return task->done; });
  std::erase_if(armed_, [](const Armed& armed) { return armed.fired; });
}

// Whatever moves the input ends: the last word is valid.
void Player::leave_alone(const std::string& input) {
  for (const auto& task : tasks_) {
    if (task->input != input) continue;
    task->wakeup.cancel();
    task->done = true;
  }
}

void Player::set_input(const std::string& input, double value) {
  bench_.set(input, value);
  tell(fmt::format("{} {}", input, show_quantity(value, bench_.registry().signal(input).unit)));
}

Task& Player::later(SimDuration delay, std::function<void()> act) {
  return start_task(
      [act = std::move(act)](Task& task) {
        task.done = true;
        act();
      },
      loop_.now() + delay);
}

void Player::run(const Apply& apply) {
  for (const auto& [name, value] : apply.inputs) {
    const double before = bench_.read(name);
    leave_alone(name);
    set_input(name, value);
    if (!apply.lasts) continue;
    later(*apply.lasts, [this, input = name, before] { set_input(input, before); }).input = name;
  }
}

void Player::move(const std::string& input, std::vector<Profile::Point> points, bool linear,
                  std::size_t repeat, bool background) {
  const SimTime begin = loop_.now();
  const SimDuration length = points.back().at;
  const SimTime end = begin + length * static_cast<std::int64_t>(repeat);
  leave_alone(input);
  tell(fmt::format("{} begins to move", input));
  Task& task = start_task(
      [this, input, points = std::move(points), linear, begin, end, length](Task& self) {
        const SimTime now = loop_.now();
        if (now >= end) {
          set_input(input, points.back().value);
          self.done = true;
          return;
        }
        const SimDuration at = length > SimDuration{} ? (now - begin) % length : SimDuration{};
        const auto next = std::ranges::upper_bound(points, at, {}, &Profile::Point::at);
        const Profile::Point& from = *std::prev(next);
        double value = from.value;
        if (linear) {
          const double share = seconds(at - from.at) / seconds(next->at - from.at);
          value += share * (next->value - from.value);
        }
        bench_.set(input, value);
        self.wakeup.at(linear ? std::min(now + kRampInterval, end) : now + (next->at - at));
      },
      begin);
  task.input = input;
  if (background) return;
  const SimTime limit = end;
  while (!task.done && loop_.now() < limit) let_pass(limit - loop_.now());
}

void Player::run(const Ramp& ramp) {
  const SimTime end = loop_.now() + ramp.over;
  for (const auto& [name, target] : ramp.targets) {
    move(name, {{SimDuration{}, bench_.read(name)}, {ramp.over, target}}, true, 1, true);
  }
  if (!ramp.background) let_pass(end - loop_.now());
}

void Player::run(const Profile& profile) {
  move(profile.input, profile.points, profile.linear, profile.repeat, profile.background);
}

void Player::run(const Inject& inject) {
  for (const auto& [name, severity] : inject.faults) {
    bench_.registry().inject(name, severity);
    tell(severity == 1 ? fmt::format("fault {}", name)
                       : fmt::format("fault {} {:.6g}", name, severity));
  }
  if (!inject.lasts) return;
  later(*inject.lasts, [this, faults = inject.faults] {
    for (const auto& [name, severity] : faults) {
      bench_.registry().clear(name);
      tell(fmt::format("{} cleared", name));
    }
  });
}

void Player::run(const Clear& clear) {
  if (clear.faults.empty()) {
    bench_.registry().clear_faults();
    tell("all faults cleared");
  }
  for (const std::string& name : clear.faults) {
    bench_.registry().clear(name);
    tell(fmt::format("{} cleared", name));
  }
}

void Player::switch_power(const std::string& drive, bool on) {
  if (on)
    bench_.drive(drive).power_on();
  else
    bench_.drive(drive).power_off();
  tell(fmt::format("power {}", on ? "on" : "off"));
}

void Player::run(const Power& power) {
  switch_power(power.drive, power.on);
  if (!power.lasts) return;
  later(*power.lasts, [this, drive = power.drive, on = !power.on] { switch_power(drive, on); });
}

void Player::run(const Reset& reset) {
  bench_.drive(reset.drive).reset();
  tell("reset");
}

void Player::run(const Note&) {
  tell(step_->text);
}

void Player::run(const RunHost& host) {
  const HostOutcome outcome = run_host_program(bench_, host);
  detail_ = outcome.summary;
  if (violation_) throw Failed{};
  if (!outcome.wrong.empty()) throw Wrong{outcome.expected, outcome.wrong};
}

void Player::run(const Repeat& repeat) {
  const int depth = depth_ + 1;
  for (std::size_t i = 0; i < repeat.count; ++i) run_steps(repeat.steps, depth);
}

}  // namespace

ScenarioResult play(const Scenario& scenario, std::uint64_t seed) {
  return Player(scenario, seed).play();
}

}  // namespace virtdrive
