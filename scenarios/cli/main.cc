// The program: options to structs, errors to one line and an exit code. What is done stands in
// run.cc, demo.cc and list.cc.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <fmt/format.h>

#include "core/check.h"
#include "core/names.h"
#include "scenarios/cli/commands.h"

namespace virtdrive {
namespace {

std::optional<double> parse_rate(const std::string& text) {
  if (text == "max") return std::nullopt;
  double rate = 0;
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, rate);
  if (error != std::errc{} || end != last || !(rate >= 1e-3 && rate <= 1e3)) {
    throw SetupError(fmt::format("--rate {}: expected 0.001 ... 1000, or max", text));
  }
  return rate;
}

CLI::Validator not_empty() {
  return {[](std::string& text) { return text.empty() ? "must not be empty" : ""; }, ""};
}

CLI::Validator not_negative() {
  return {[](std::string& text) {
            return text.starts_with('-') ? text + ": must not be negative" : std::string();
          },
          "NUMBER >= 0"};
}

void add_run(CLI::App& app, std::function<int()>& action) {
  CLI::App* command = app.add_subcommand("run", "Put a drive on a pseudo-terminal and run it");
  auto options = std::make_shared<RunOptions>();
  BenchOptions& bench = options->bench;
  DriveSpec& drive = bench.drives.emplace_back();
  LineSpec& line = bench.lines.front();
  // Words that the callback turns into what they mean.
  struct Words {
    std::string rate = "1";
    std::string line = "real";
    std::string integrator = "default";
  };
  auto words = std::make_shared<Words>();

  command->add_option("DRIVE", drive.kind, "The drive: see 'virtdrive list drives'")->required();
  CLI::Option* const link =
      command->add_option("--link", options->link, "Make this path a symlink to the terminal")
          ->check(not_empty());
  command
      ->add_option("--link2", options->link2,
                   "A terminal with this link for the drive's second port, where it has one")
      ->check(not_empty());
  command
      ->add_option("--link3", options->link3,
                   "A terminal with this link for the drive's third port, where it has one")
      ->check(not_empty());
  command
      ->add_option("--can-link", options->can_link,
                   "A terminal with this link for an SLCAN adapter at the drive's CAN port")
      ->check(not_empty());
  CLI::Option* const tcp =
      command
          ->add_option("--tcp", options->tcp,
                       "Listen on [HOST:]PORT (127.0.0.1 unless told) instead of a terminal")
          ->check(not_empty())
          ->excludes(link);
  CLI::Option* const rfc2217 =
      command
          ->add_option("--rfc2217", options->rfc2217,
                       "The same, with RFC 2217: baud rate and parity are the host's to set")
          ->check(not_empty())
          ->excludes(link)
          ->excludes(tcp);
  command
      ->add_option("--port", options->port,
                   "Use an existing serial device, e.g. /dev/ttyUSB0: the drive at its other end")
      ->check(not_empty())
      ->excludes(link)
      ->excludes(tcp)
      ->excludes(rfc2217);
  command
      ->add_option("--line", words->line,
                   "real: character times and the drive's latency; ideal: none")
      ->check(CLI::IsMember({"real", "ideal"}))
      ->capture_default_str();
  command
      ->add_option(
          "--motor", drive.motors,
          "The motor, or one a channel (A,B,C): a name of 'virtdrive list motors', or the path "
          "of a YAML file")
      ->delimiter(',');
  command->add_option("--load", drive.load, kLoadHelp)->check(not_empty())->capture_default_str();
  command
      ->add_option("--rate", words->rate, "Simulated seconds per second (0.001 ... 1000), or max")
      ->capture_default_str();
  command->add_option("--seed", bench.seed, "Seed of all noise")
      ->check(not_negative())
      ->capture_default_str();
  command
      ->add_option("--set", drive.set,
                   "[CHANNEL.]PARAMETER=VALUE[UNIT], as the host would write it; may be repeated")
      ->allow_extra_args(false);
  command->add_option("--start", options->start, "Start a motor at once: [CHANNEL:]RPM")
      ->check(not_empty());
  command->add_option("--baud", line.baud, "The drive's baud rate")
      ->check(CLI::Range(50, 12'000'000));
  command->add_option("--integrator", words->integrator, "default: SUNDIALS ERKStep; fast: RK4")
      ->check(CLI::IsMember({"default", "fast"}))
      ->capture_default_str();
  command
      ->add_option("--nvm", drive.nvm,
                   "Keep what the drive stores in this file; without it nothing outlives the run")
      ->check(not_empty());
  command->add_flag("--lenient", drive.lenient,
                    "Forgive what the drive does not: bytes sent while it is busy, cut telegrams");
  command->add_flag("--trace", options->trace, "Show each frame, decoded, on standard error");
  command
      ->add_option("--record", options->record,
                   "Write signals to this file: .csv, .vcd (GTKWave) or .mat")
      ->check(not_empty());
  command->add_option("--signals", options->signals, "What to record: see 'virtdrive list signals'")
      ->delimiter(',');
  command
      ->add_option("--interval", options->interval_s, "Seconds between two rows of the recording")
      ->check(CLI::Range(1e-6, 1e3))
      ->capture_default_str();
  command
      ->add_option("--wire", options->wire,
                   "Record the line to this pcapng file, for Wireshark and 'virtdrive replay'")
      ->check(not_empty());
  command->add_option("--duration", options->duration_s, "End after so many simulated seconds")
      ->check(CLI::Range(0.0, 1e9));
  command
      ->add_option("--control", options->control,
                   "Take requests on a Unix socket at this path: see 'virtdrive ctl'")
      ->check(not_empty());
  command->add_flag("--json", options->json, "Ready line and report as JSON, a line each");
  command->callback([options, words, &action] {
    options->rate = parse_rate(words->rate);
    options->bench.lines.front().timing =
        words->line == "ideal" ? LineTiming::kIdeal : LineTiming::kReal;
    options->bench.integrator =
        words->integrator == "fast" ? Integrator::kFast : Integrator::kDefault;
    action = [options] { return run(*options); };
  });
}

void add_demo(CLI::App& app, std::function<int()>& action) {
  CLI::App* command = app.add_subcommand(
      "demo", "Run a motor through a real terminal: 2000 rpm, a load step, stop; takes 6 s");
  auto options = std::make_shared<DemoOptions>();
  command->add_option("--link", options->link, "Make this path a symlink to the terminal");
  command
      ->add_option("--report", options->report,
                   "Write plots of it all to this HTML file; \"\" for none")
      ->capture_default_str();
  command->callback([options, &action] { action = [options] { return demo(*options); }; });
}

void add_replay(CLI::App& app, std::function<int()>& action) {
  CLI::App* command = app.add_subcommand(
      "replay", "Play a recorded host again and compare what the drive says, byte by byte");
  auto replayed = std::make_shared<ReplayCommand>();
  ReplayOptions& options = replayed->options;
  command->add_option("FILE", replayed->file, "A recording of 'run --wire'")->required();
  command->add_option("--wire", options.wire, "Record the replay to this file")->check(not_empty());
  command->add_option("--motor", options.motors, "Another motor, or one a channel (A,B,C)")
      ->delimiter(',');
  command->add_option("--load", options.load, kLoadHelp)->check(not_empty());
  command->add_option("--seed", options.seed, "Another seed of all noise")->check(not_negative());
  command
      ->add_option("--set", options.set,
                   "[CHANNEL.]PARAMETER=VALUE[UNIT], beside the recorded ones; may be repeated")
      ->allow_extra_args(false);
  auto tolerance_ms = std::make_shared<double>(0);
  command
      ->add_option("--tolerance", *tolerance_ms,
                   "Milliseconds by which a byte may come earlier or later than recorded")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  CLI::Option* const signals =
      command
          ->add_option("--signals", options.signals,
                       "Compare the signals too: the CSV file that 'run --record' wrote beside")
          ->check(not_empty());
  command
      ->add_option("--signal-tolerance", options.signal_tolerance,
                   "By how much a signal may be off, as a share of its largest recorded size")
      ->check(CLI::Range(0.0, 1.0))
      ->needs(signals)
      ->capture_default_str();
  command->add_flag("--json", replayed->json, "The result as a line of JSON");
  command->callback([replayed, tolerance_ms, &action] {
    replayed->options.tolerance = from_seconds(*tolerance_ms / 1e3);
    action = [replayed] { return replay(*replayed); };
  });
}

void add_list(CLI::App& app, std::function<int()>& action) {
  CLI::App* command = app.add_subcommand("list", "Show what there is");
  command->require_subcommand(1);
  CLI::App* drives = command->add_subcommand("drives", "The drives");
  auto names_only = std::make_shared<bool>(false);
  drives->add_flag("--names", *names_only, "Names only, one a line");
  drives->callback(
      [names_only, &action] { action = [names_only] { return list_drives(*names_only); }; });
  command->add_subcommand("motors", "The motor library")->callback([&action] {
    action = list_motors;
  });
  const auto of_drive = [&](const char* name, const char* doc, int (*show)(const std::string&)) {
    CLI::App* what = command->add_subcommand(name, doc);
    auto drive = std::make_shared<std::string>();
    what->add_option("DRIVE", *drive, "The drive")->required();
    what->callback([drive, show, &action] { action = [drive, show] { return show(*drive); }; });
  };
  of_drive("signals", "What can be recorded and set on a drive's bench", list_signals);
  of_drive("parameters", "A drive's parameters, for --set", list_parameters);
}

void add_motor(CLI::App& app, std::function<int()>& action) {
  CLI::App* command =
      app.add_subcommand("motor", "Show, check or plot a motor of the library or of a file");
  auto options = std::make_shared<MotorOptions>();
  command->add_option("MOTOR", options->motor,
                      "A name of 'virtdrive list motors', or a file's path");
  command
      ->add_option("--plot", options->plot,
                   "Write torque, power and current over speed and the efficiency map to this SVG")
      ->check(not_empty());
  command->add_flag("--check", options->check, "Only say whether the file is good");
  command->add_flag("--json", options->json, "The set with its derived constants as JSON");
  command->add_flag("--schema", options->schema, "Print the JSON schema of motor files");
  command->add_flag("--keys", options->keys, "Print the keys of motor files as a Markdown table");
  command->callback([options, &action] { action = [options] { return motor(*options); }; });
}

// "2/5": the second of five parts.
void parse_shard(const std::string& text, SuiteOptions& suite) {
  const char* const last = text.data() + text.size();
  const auto [slash, error] = std::from_chars(text.data(), last, suite.shard);
  bool good = error == std::errc{} && slash != last && *slash == '/';
  if (good) {
    const auto [end, bad] = std::from_chars(slash + 1, last, suite.shards);
    good = bad == std::errc{} && end == last;
  }
  if (!good || suite.shard < 1 || suite.shard > suite.shards) {
    throw SetupError(fmt::format("--shard {}: expected I/N with 1 <= I <= N", text));
  }
}

void add_test(CLI::App& app, std::function<int()>& action) {
  CLI::App* command = app.add_subcommand("test", "Play scenarios and say which failed");
  auto options = std::make_shared<TestOptions>();
  auto shard = std::make_shared<std::string>("1/1");
  SuiteOptions& suite = options->suite;
  command
      ->add_option("PATH", suite.paths,
                   "Scenario files, and folders of them: see docs/scenarios.md")
      ->required();
  command->add_option("-k", suite.pattern, "Only those with this text in path, name or a tag");
  command->add_flag("--list", options->list, "Check the files and show what would be played");
  command->add_flag("--long", suite.with_long, "Those tagged 'long' too");
  command->add_option("--seed", suite.seed, "Seed of all noise, instead of each file's own")
      ->check(not_negative());
  command->add_option("--repeat", suite.repeat, "Play each so often, with the seeds that follow")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--shard", *shard, "I/N: only every N-th, from the I-th on")
      ->capture_default_str();
  command->add_option("--jobs", suite.jobs, "So many at once; 0: one a core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  command->add_option("--junit", options->junit, "Write a JUnit XML file")->check(not_empty());
  command->add_option("--json", options->json, "Write the results as JSON")->check(not_empty());
  command->add_option("--html", options->html, "Write a report for people into this folder")
      ->check(not_empty());
  command->callback([options, shard, &action] {
    parse_shard(*shard, options->suite);
    action = [options] { return test(*options); };
  });
}

void add_ctl(CLI::App& app, std::function<int()>& action) {
  CLI::App* command = app.add_subcommand("ctl", "Ask something of a bench that runs");
  auto options = std::make_shared<CtlOptions>();
  command->add_option("SOCKET", options->socket, "The path of its --control")->required();
  command
      ->add_option(
          "REQUEST", options->word,
          "status, list, read NAME, set NAME VALUE, inject NAME [SEVERITY], clear NAME|all, "
          "power on|off, reset, rate VALUE (0 stands still), step SECONDS")
      ->required();
  command->add_option("ARGUMENT", options->arguments, "As above")->expected(0, 2);
  command->add_option("--drive", options->drive, "Which, where the bench has several");
  command->add_flag("--json", options->json, "Print the answer as it came");
  command->callback([options, &action] { action = [options] { return ctl(*options); }; });
}

// How a real line is set; `parity` is to be read once the words have been.
struct ParityWord {
  std::string word = "none";
  Parity value() const {
    return word == "none" ? Parity::kNone : word == "even" ? Parity::kEven : Parity::kOdd;
  }
};

void add_line_options(CLI::App& command, std::optional<int>& baud, ParityWord& parity) {
  command.add_option("--baud", baud, "The line's baud rate, if not the protocol's own")
      ->check(CLI::Range(50, 12'000'000));
  command.add_option("--parity", parity.word, "The line's parity")
      ->check(CLI::IsMember({"none", "even", "odd"}))
      ->capture_default_str();
}

void add_check(CLI::App& app, std::function<int()>& action) {
  CLI::App* check_command =
      app.add_subcommand("check", "Judge whether a drive keeps to its protocol");
  check_command->require_subcommand(1);
  CLI::App* command = check_command->add_subcommand(
      "drive", "Put every row of a protocol's table to a drive, emulated or real");
  auto options = std::make_shared<CheckOptions>();
  auto parity = std::make_shared<ParityWord>();
  auto allow = std::make_shared<std::string>("reads");
  CLI::Option* const port =
      command->add_option("--port", options->port, "The device's serial port, or tcp://HOST:PORT");
  command->add_option("--drive", options->drive, "One of 'virtdrive list drives', in virtual time")
      ->excludes(port);
  command->add_option(
      "--protocol", options->protocol,
      "What the device speaks: a drive of 'virtdrive list drives', or its protocol");
  add_line_options(*command, options->baud, *parity);
  command
      ->add_option("--allow", *allow,
                   "reads: changes nothing; writes: settings are changed and written back, the "
                   "motor must stand free; moves: commands too, MOTORS START")
      ->check(CLI::IsMember({"reads", "writes", "moves"}))
      ->capture_default_str();
  command->add_option("--channel", options->channel, "The motor's number, or the device's ID");
  command->add_flag("--factory", options->factory, "It has its factory settings: compare them");
  command
      ->add_option("--patience", options->patience_s,
                   "Seconds that an answer may take at the most, if not the protocol's own")
      ->check(CLI::Range(1e-3, 60.0));
  command
      ->add_option("--silence", options->silence_s,
                   "Seconds without a byte after which the device is taken to be silent")
      ->check(CLI::Range(1e-3, 60.0))
      ->capture_default_str();
  command->add_option("--most-failures", options->most_failures, "Give up after so many")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  command->add_option("--junit", options->junit, "Write a JUnit XML file")->check(not_empty());
  command->add_option("--json", options->json, "Write each check as JSON")->check(not_empty());
  command->callback([options, parity, allow, &action] {
    options->parity = parity->value();
    options->allow = *allow == "reads"    ? protocol::Allow::kReads
                     : *allow == "writes" ? protocol::Allow::kWrites
                                          : protocol::Allow::kMoves;
    action = [options] { return check(*options); };
  });
}

void add_monitor(CLI::App& app, std::function<int()>& action) {
  CLI::App* command = app.add_subcommand(
      "monitor", "Show what passes on a line, decoded: of a recording, or between host and device");
  auto options = std::make_shared<MonitorOptions>();
  auto parity = std::make_shared<ParityWord>();
  command->add_option("FILE", options->file,
                      "A recording of 'run --wire', also one that is being written to a pipe; -: "
                      "standard input");
  command
      ->add_option("--tap", options->tap,
                   "DEVICE HOST: sit between a device's port (or tcp://HOST:PORT) and the host's, "
                   "a serial port or a terminal to be made under this name")
      ->expected(2);
  command->add_option("--protocol", options->protocol,
                      "What a tapped device speaks: a drive of 'virtdrive list drives', or its "
                      "protocol");
  add_line_options(*command, options->baud, *parity);
  command->add_option("--wire", options->wire, "Record what passes the tap to this pcapng file")
      ->check(not_empty());
  command->add_option("--color", options->color, "Colours")
      ->check(CLI::IsMember({"auto", "always", "never"}))
      ->capture_default_str();
  command->add_flag("--json", options->json, "A line of JSON for each packet");
  command->callback([options, parity, &action] {
    options->parity = parity->value();
    action = [options] { return monitor(*options); };
  });
}

void add_host(CLI::App& app, std::function<int()>& action) {
  CLI::App* command =
      app.add_subcommand("host", "Talk to a drive, emulated or real, in the words of its protocol");
  auto options = std::make_shared<HostOptions>();
  auto parity = std::make_shared<ParityWord>();
  command->add_option("PORT", options->port, "A serial port, or tcp://HOST:PORT")->required();
  command
      ->add_option(
          "ACTION", options->action,
          "get NAME..., set NAME=VALUE..., call COMMAND [FIELD=VALUE...], start RPM, stop, "
          "watch NAME..., dump [FILE], restore FILE, diff FILE [FILE]")
      ->required();
  command->add_option("ARGUMENT", options->arguments, "As above");
  command
      ->add_option("--protocol", options->protocol,
                   "What it speaks: a drive of 'virtdrive list drives', or its protocol")
      ->required();
  add_line_options(*command, options->baud, *parity);
  command
      ->add_option("--channel", options->channels,
                   "The motor's number; of a dump, as many as there are (0,1,2)")
      ->delimiter(',');
  command->add_option("--every", options->every_s, "Seconds between two looks of a watch")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  command->add_option("--count", options->count, "Looks of a watch; 0: until Ctrl-C")
      ->capture_default_str();
  command->add_flag("--json", options->json, "Values as JSON, a line each");
  command->callback([options, parity, &action] {
    options->parity = parity->value();
    action = [options] { return host(*options); };
  });
}

void add_schema(CLI::App& app, std::function<int()>& action) {
  app.add_subcommand("schema", "Print the JSON schema of scenario files, for editors")
      ->callback([&action] { action = print_schema; });
}

void add_document(CLI::App& app, std::function<int()>& action) {
  CLI::App* command = app.add_subcommand(
      "document", "Print a drive's protocol, or a page of scenarios, as Markdown");
  struct Words {
    std::string drive;
    std::vector<std::string> scenarios;
  };
  auto words = std::make_shared<Words>();
  CLI::Option* const drive = command->add_option("DRIVE", words->drive, "The drive");
  CLI::Option* const scenarios =
      command->add_option("--scenarios", words->scenarios, "Scenario files and folders of them")
          ->excludes(drive);
  command->callback([words, drive, scenarios, &action] {
    if (drive->empty() && scenarios->empty()) {
      throw SetupError("document: expected a drive, or --scenarios PATH");
    }
    action = [words] {
      return words->drive.empty() ? document_scenarios(words->scenarios)
                                  : document_drive(words->drive);
    };
  });
}

// "virtdrive run": the words of the sub-command that was being read.
std::string asked_of(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return app.get_name() + (chosen.empty() ? "" : " " + asked_of(*chosen.front()));
}

std::string one_line(std::string text) {
  std::ranges::replace(text, '\n', ' ');
  return text;
}

void check_command(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands(nullptr)) names.push_back(command->get_name());
  if (std::ranges::find(names, argv[1]) != names.end()) return;
  throw SetupError(unknown_name("command", argv[1], {names.begin(), names.end()}));
}

int run_program(int argc, char** argv) {
  CLI::App app{"A virtual test bench for motor drives."};
  app.name("virtdrive");
  app.set_version_flag("--version", VIRTDRIVE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 the run or a scenario failed, 2 an option, name, file or port cannot "
      "be "
      "used.");
  std::function<int()> action;
  add_run(app, action);
  add_demo(app, action);
  add_replay(app, action);
  add_test(app, action);
  add_ctl(app, action);
  add_check(app, action);
  add_monitor(app, action);
  add_host(app, action);
  add_list(app, action);
  add_motor(app, action);
  add_schema(app, action);
  add_document(app, action);
  check_command(app, argc, argv);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    throw SetupError(
        fmt::format("{}; '{} --help' tells more", one_line(error.what()), asked_of(app)));
  }
  return action();
}

}  // namespace
}  // namespace virtdrive

int main(int argc, char** argv) {
  try {
    return virtdrive::run_program(argc, argv);
  } catch (const virtdrive::SetupError& error) {
    fmt::print(stderr, "virtdrive: {}\n", error.what());
    return virtdrive::kExitUsage;
  } catch (const std::exception& error) {
    fmt::print(stderr, "virtdrive: {}\n", error.what());
    return virtdrive::kExitFailed;
  }
}
