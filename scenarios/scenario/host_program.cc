#include "scenarios/scenario/host_program.h"

#include <atomic>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <stdexcept>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "core/check.h"
#include "pty/file_descriptor.h"
#include "pty/pty_endpoint.h"
#include "pty/runner.h"
#include "scenarios/scenario/quantity.h"

extern char** environ;

namespace virtdrive {
namespace {

constexpr std::size_t kMostOutput = 65536;
constexpr std::size_t kShownOutput = 600;

struct Terminal {
  std::string line;
  std::unique_ptr<PtyEndpoint> endpoint;
};

std::string with_ports(std::string text, const std::vector<Terminal>& terminals) {
  const auto replace = [&](const std::string& what, const std::string& by) {
    for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size()) {
      text.replace(at, what.size(), by);
    }
  };
  for (const Terminal& terminal : terminals) {
    replace(fmt::format("{{port:{}}}", terminal.line), terminal.endpoint->path());
  }
  replace("{port}", terminals.front().endpoint->path());
  return text;
}

std::vector<std::string> environment(const std::vector<Terminal>& terminals) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (!std::string_view(*variable).starts_with("VIRTDRIVE_PORT")) {
      variables.emplace_back(*variable);
    }
  }
  variables.push_back(fmt::format("VIRTDRIVE_PORT={}", terminals.front().endpoint->path()));
  for (const Terminal& terminal : terminals) {
    std::string name = terminal.line;
    for (char& c : name) {
      c = std::isalnum(static_cast<unsigned char>(c)) != 0
              ? static_cast<char>(std::toupper(static_cast<unsigned char>(c)))
              : '_';
    }
    variables.push_back(fmt::format("VIRTDRIVE_PORT_{}={}", name, terminal.endpoint->path()));
  }
  return variables;
}

// The program, its output, and the thread that waits for it.
class Program {
 public:
  Program(const std::string& command, const std::vector<std::string>& variables) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) fail("pipe");
    output_ = FileDescriptor{ends[0]};
    const FileDescriptor write_end{ends[1]};
    std::vector<char*> env;
    for (const std::string& variable : variables)
      env.push_back(const_cast<char*>(variable.c_str()));
    env.push_back(nullptr);
    const char* const argv[] = {"sh", "-c", command.c_str(), nullptr};

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);  // so that all of it can be ended
    const int error = posix_spawn(&pid_, "/bin/sh", &actions, &attributes,
                                  const_cast<char* const*>(argv), env.data());
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (error != 0) {
      errno = error;
      fail("posix_spawn");
    }
  }

  // Reads what it says and waits for its end; of another thread.
  void wait() {
    char buffer[4096];
    while (true) {
      const ssize_t got = ::read(output_.get(), buffer, sizeof buffer);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) break;
      said_.append(buffer, std::min(static_cast<std::size_t>(got), kMostOutput - said_.size()));
    }
    while (waitpid(pid_, &status_, 0) < 0 && errno == EINTR) {
    }
    ended_ = true;
  }
  void kill() { ::kill(-pid_, SIGKILL); }
  bool ended() const { return ended_; }
  int status() const { return status_; }
  const std::string& said() const { return said_; }

 private:
  [[noreturn]] static void fail(std::string_view what) {
    throw SetupError(
        fmt::format("a host program cannot be started: {}: {}", what, std::strerror(errno)));
  }

  pid_t pid_ = 0;
  FileDescriptor output_;
  std::string said_;
  int status_ = 0;
  std::atomic<bool> ended_ = false;
};

std::string shown(const std::string& said) {
  if (said.empty()) return "it printed nothing";
  const std::string end =
      said.size() > kShownOutput ? "... " + said.substr(said.size() - kShownOutput) : said;
  return "it printed:\n" + end;
}

}  // namespace

HostOutcome run_host_program(Bench& bench, const RunHost& host) {
  std::vector<Terminal> terminals;
  for (const auto& drive : bench.drives()) {
    const std::string name(bench.line_name(drive->line()));
    const auto same = [&](const Terminal& terminal) { return terminal.line == name; };
    if (std::ranges::any_of(terminals, same)) continue;
    terminals.push_back({name, std::make_unique<PtyEndpoint>(drive->line())});
  }
  const SimTime begin = bench.loop().now();
  const SimDuration longest = from_seconds(seconds(host.timeout) * host.rate);
  Runner runner(bench.loop(), {.rate = host.rate, .until = begin + longest});
  for (const Terminal& terminal : terminals) runner.add(*terminal.endpoint);
  Program program(with_ports(host.command, terminals), environment(terminals));
  std::thread waiter([&] {
    program.wait();
    runner.request_stop();
  });
  const int interrupted = runner.run().signal;
  const bool in_time = program.ended();
  if (!in_time) program.kill();
  waiter.join();
  if (interrupted != 0) throw std::runtime_error("interrupted");
  for (const Terminal& terminal : terminals) terminal.endpoint->flush();

  const int status = program.status();
  const std::string how = !in_time ? "ended by the time-out"
                          : WIFSIGNALED(status)
                              ? fmt::format("ended by signal {}", WTERMSIG(status))
                              : fmt::format("exit code {}", WEXITSTATUS(status));
  HostOutcome outcome{
      .summary = fmt::format("{}; {}", how, shown(program.said())), .expected = {}, .wrong = {}};
  if (!in_time) {
    outcome.expected = fmt::format("the program to end within {}", show_time(host.timeout));
    outcome.wrong = fmt::format("it was still running; {}", shown(program.said()));
  } else if (!WIFEXITED(status) || WEXITSTATUS(status) != host.exit_code) {
    outcome.expected = fmt::format("exit code {}", host.exit_code);
    outcome.wrong = outcome.summary;
  } else if (program.said().find(host.output) == std::string::npos) {
    outcome.expected = fmt::format("'{}' in its output", host.output);
    outcome.wrong = shown(program.said());
  }
  return outcome;
}

}  // namespace virtdrive
