// What the program does, a function a sub-command. Each returns the exit code.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "devices/protocol/walk.h"
#include "scenarios/bench.h"
#include "scenarios/replay.h"
#include "scenarios/scenario/suite.h"

namespace virtdrive {

inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;  // the demo or the run went wrong
inline constexpr int kExitUsage = 2;   // an option, a name, a file or a port that cannot be used

struct RunOptions {
  BenchOptions bench;
  std::string link;
  std::string link2, link3;          // further terminals, for the drive's further ports
  std::string can_link;              // one for an SLCAN adapter at the drive's CAN port
  std::string tcp;                   // [HOST:]PORT to listen on instead of a pseudo-terminal
  std::string rfc2217;               // the same, with RFC 2217
  std::string port;                  // or an existing serial device
  std::optional<double> rate = 1.0;  // none: as fast as possible
  std::string record;
  std::vector<std::string> signals;
  double interval_s = 1e-3;
  std::string wire;  // file of what passes on the line; empty: none
  std::optional<double> duration_s;
  std::string start;    // [CHANNEL:]RPM
  std::string control;  // path of a socket for requests; empty: none
  bool trace = false;
  bool json = false;
};
int run(const RunOptions& options);

struct DemoOptions {
  std::string link;
  std::string report = "virtdrive-demo.html";  // HTML file; empty: none
};
int demo(const DemoOptions& options);

struct MotorOptions {
  std::string motor;  // a name or a file's path
  std::string plot;   // SVG file; empty: none
  bool check = false;
  bool json = false;
  bool schema = false;  // of motor files, instead
  bool keys = false;    // the same as a Markdown table
};
int motor(const MotorOptions& options);

struct ReplayCommand {
  std::string file;
  ReplayOptions options;
  bool json = false;
};
/// kExitFailed if the drives do not say what they said.
int replay(const ReplayCommand& command);

struct TestOptions {
  SuiteOptions suite;
  std::string junit;  // files; empty: none
  std::string json;
  std::string html;  // folder; empty: none
  bool list = false;
};
int test(const TestOptions& options);

struct CtlOptions {
  std::string socket;
  std::string word;
  std::vector<std::string> arguments;
  std::string drive;  // empty: the first
  bool json = false;
};
/// kExitFailed if the bench refuses.
int ctl(const CtlOptions& options);

struct CheckOptions {
  std::string port;   // of a device: a terminal, or tcp://HOST:PORT
  std::string drive;  // or one of ours, in virtual time
  std::string protocol;
  std::optional<int> baud;
  Parity parity = Parity::kNone;
  protocol::Allow allow = protocol::Allow::kReads;
  std::optional<std::uint8_t> channel;
  bool factory = false;              // compare with the table's factory settings
  std::optional<double> patience_s;  // none: the protocol's
  double silence_s = 0.05;
  std::size_t most_failures = 100;
  std::string junit;  // files; empty: none
  std::string json;
};
/// kExitFailed if the drive does not keep to its table.
int check(const CheckOptions& options);

struct MonitorOptions {
  std::string file;              // a recording, a pipe that one is written to, or "-"; or else
  std::vector<std::string> tap;  // the device's port and the host's
  std::string protocol;          // of a tap
  std::optional<int> baud;       // none: the protocol's
  Parity parity = Parity::kNone;
  std::string wire;  // recording of a tap; empty: none
  std::string color = "auto";
  bool json = false;
};
int monitor(const MonitorOptions& options);

struct HostOptions {
  std::string port;      // a terminal, or tcp://HOST:PORT
  std::string protocol;  // of a drive's, or a drive
  std::string action;
  std::vector<std::string> arguments;
  std::vector<std::string> channels;  // none: the protocol's default one
  std::optional<int> baud;            // none: the protocol's
  Parity parity = Parity::kNone;
  double every_s = 0.5;
  std::uint64_t count = 0;  // of a watch; 0: until it is ended
  bool json = false;
};
/// kExitFailed if the drive refuses, is silent, or is not as the dump says.
int host(const HostOptions& options);

/// The JSON schema of scenario files.
int print_schema();

int list_drives(bool names_only);
int list_motors();
int list_signals(const std::string& drive);
int list_parameters(const std::string& drive);
int document_drive(const std::string& drive);
int document_scenarios(const std::vector<std::string>& paths);

}  // namespace virtdrive
