#include "pty/runner.h"

#include <algorithm>
#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <sys/eventfd.h>
#include <sys/prctl.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include "core/check.h"

namespace virtdrive {
namespace {

namespace asio = boost::asio;

constexpr WallDuration kCatchUp = std::chrono::milliseconds{1};
constexpr SimDuration kFreeChunk = std::chrono::milliseconds{10};

WallTime wall_now() {
  return std::chrono::steady_clock::now();
}

/// a + d, without running over the end of time.
SimTime later(SimTime a, double ns) {
  return ns >= static_cast<double>((kNever - a).count())
             ? kNever
             : a + SimDuration{static_cast<std::int64_t>(ns)};
}

int open_event() {
  const int fd = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (fd < 0) throw SetupError(fmt::format("cannot make an eventfd: {}", std::strerror(errno)));
  return fd;
}

}  // namespace

struct Runner::Outside {
  struct Port {
    Port(asio::io_context& context, HostEndpoint& host_endpoint)
        : endpoint(host_endpoint), descriptor(context, host_endpoint.fd()) {
      arm();
    }
    ~Port() { descriptor.release(); }  // the descriptor is the endpoint's

    void arm() {
      ready = false;
      descriptor.async_wait(asio::posix::stream_descriptor::wait_read,
                            [this](const boost::system::error_code& error) { ready = !error; });
    }

    HostEndpoint& endpoint;
    asio::posix::stream_descriptor descriptor;
    bool ready = false;
  };

  Outside() {
    // A terminal that is closed ends the run as well, unless nohup says otherwise.
    struct sigaction hang_up{};
    if (sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN) {
      signals.add(SIGHUP);
    }
    signals.async_wait([this](const boost::system::error_code& error, int number) {
      if (!error) {
        signal = number;
        stop = true;
      }
    });
    stop_event.async_wait(asio::posix::stream_descriptor::wait_read,
                          [](const boost::system::error_code&) {});
  }

  asio::io_context context{1};
  asio::steady_timer timer{context};
  asio::signal_set signals{context, SIGINT, SIGTERM};
  const int stop_fd = open_event();  // closed by stop_event
  asio::posix::stream_descriptor stop_event{context, stop_fd};
  std::atomic<bool> stop = false;
  int signal = 0;
  std::vector<std::unique_ptr<Port>> ports;
};

Runner::Runner(EventLoop& loop, RunnerOptions options)
    : loop_(loop), options_(std::move(options)), outside_(std::make_unique<Outside>()) {}

Runner::~Runner() = default;

void Runner::add(HostEndpoint& endpoint) {
  outside_->ports.push_back(std::make_unique<Outside::Port>(outside_->context, endpoint));
}

bool Runner::set_rate(double rate) {
  if (!pacer_) return false;
  pacer_->set_rate(rate, loop_.now(), wall_now());
  return true;
}

bool Runner::step(SimDuration time) {
  if (!pacer_ || pacer_->rate() != 0) return false;
  pacer_->set_rate(0, std::max(loop_.now(), pacer_->sim_at(wall_now())) + time, wall_now());
  return true;
}

void Runner::request_stop() {
  outside_->stop = true;
  const std::uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = ::write(outside_->stop_fd, &one, sizeof one);
}

PacingReport Runner::run() {
  prctl(PR_SET_TIMERSLACK, 1UL);  // wake-ups 21 us late at the median instead of 71 us
  sim_begin_ = loop_.now();
  wall_begin_ = wall_now();
  next_status_ = options_.status ? wall_begin_ + options_.status_interval : WallTime::max();
  if (options_.rate) {
    pacer_.emplace(*options_.rate, sim_begin_, wall_begin_);
    run_paced();
  } else {
    run_free();
  }
  return report(wall_now());
}

void Runner::run_paced() {
  SimTime planned = loop_.now();
  while (!outside_->stop && loop_.now() < options_.until) {
    const WallTime wall = wall_now();
    pacer_->resume(planned, wall);
    if (!advance(std::min(std::max(loop_.now(), pacer_->sim_at(wall)), options_.until))) return;
    show_status(wall);
    if (pacer_->rate() == 0) {  // stands still, unless it has been told to step
      wait_until(loop_.now() < pacer_->sim_at(wall) ? wall : next_status_);
      continue;
    }
    const SimTime catch_up =
        later(loop_.now(), static_cast<double>(kCatchUp.count()) * pacer_->rate());
    planned =
        std::min({loop_.next(Phase::kDevice), std::max(loop_.next(), catch_up), options_.until});
    // A status line is no appointment: being woken for it early must not hide, or feign, a lag.
    wait_until(std::min(pacer_->wall_at(planned), next_status_));
  }
}

void Runner::run_free() {
  while (!outside_->stop && loop_.now() < options_.until) {
    const SimTime chunk = later(loop_.now(), static_cast<double>(kFreeChunk.count()));
    const SimTime target = std::min(std::max(loop_.next(), chunk), options_.until);
    if (target == kNever) {  // nothing will ever happen by itself
      if (outside_->ports.empty()) return;
      if (!advance(loop_.now())) return;
      if (loop_.next() == kNever) wait_until(next_status_);
    } else {
      if (!advance(target)) return;
      outside_->context.poll();
    }
    show_status(wall_now());
  }
}

/// Brings the loop to `target`, with what the world outside has said put in at that moment. False
/// if a callback stopped the loop on the way.
bool Runner::advance(SimTime target) {
  ++wakeups_;
  loop_.run_before(target);
  if (!loop_.stopped()) {
    for (const auto& port : outside_->ports) {
      if (!port->ready) continue;
      port->endpoint.readable();
      port->arm();
    }
    loop_.run_until(target);
  }
  for (const auto& port : outside_->ports) port->endpoint.flush();
  return !loop_.stopped();
}

void Runner::wait_until(WallTime wall) {
  if (wall > wall_now()) {
    outside_->timer.expires_at(
        std::chrono::time_point_cast<std::chrono::steady_clock::duration>(wall));
    outside_->timer.async_wait([](const boost::system::error_code&) {});
    outside_->context.run_one();
    outside_->timer.cancel();
  }
  outside_->context.poll();
}

void Runner::show_status(WallTime wall) {
  if (wall < next_status_) return;
  options_.status(report(wall));
  next_status_ = wall + options_.status_interval;
}

PacingReport Runner::report(WallTime wall) const {
  PacingReport report = pacer_ ? pacer_->report() : PacingReport{};
  report.simulated = loop_.now() - sim_begin_;
  report.elapsed = wall - wall_begin_;
  report.wakeups = wakeups_;
  report.signal = outside_->signal;
  return report;
}

}  // namespace virtdrive
