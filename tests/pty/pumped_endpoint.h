// An endpoint with a line and a listening device, advanced by hand instead of by a runner: the test
// is the host, in the same thread. Waiting means poll() with a deadline.
#pragma once

#include <chrono>
#include <functional>
#include <initializer_list>
#include <poll.h>
#include <vector>

#include "pty/pty_endpoint.h"
#include "pty/serial_line.h"

namespace virtdrive {

template <typename Endpoint>
class Pumped : public SerialReceiver {
 public:
  static constexpr std::chrono::seconds kDeadline{10};

  template <typename... Arguments>
  explicit Pumped(const LineSettings& settings = {.timing = LineTiming::kIdeal},
                  const Arguments&... arguments)
      : line(loop, settings), endpoint(line, arguments...) {
    line.add_device().attach(*this);
  }

  void receive(std::uint8_t byte) override { heard.push_back(byte); }

  /// Lets the endpoint work, `step` of simulated time at each look, until the condition holds;
  /// false if it does not within the deadline.
  bool pump(const std::function<bool()>& condition, SimDuration step = SimDuration{0}) {
    const auto deadline = std::chrono::steady_clock::now() + kDeadline;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      if (ready(1)) endpoint.readable();
      loop.run_until(loop.now() + step);
      endpoint.flush();
    }
    return true;
  }

  /// Would a runner be woken?
  bool ready(int timeout_ms = 0) const {
    pollfd descriptor{endpoint.fd(), POLLIN, 0};
    return poll(&descriptor, 1, timeout_ms) > 0;
  }

  /// The device sends, and what has left goes to the host at once.
  void say(const std::vector<std::uint8_t>& bytes) {
    line.device(0).send(bytes);
    loop.run_until(loop.now() + line.settings().time_of(static_cast<std::int64_t>(bytes.size())));
    endpoint.flush();
  }

  /// Waits until a host's descriptor has something to read.
  static bool readable(int fd) {
    pollfd descriptor{fd, POLLIN, 0};
    return poll(&descriptor, 1, std::chrono::milliseconds{kDeadline}.count()) > 0;
  }

  static bool readable_now(int fd) {
    pollfd descriptor{fd, POLLIN, 0};
    return poll(&descriptor, 1, 0) > 0;
  }

  EventLoop loop;
  SerialLine line;
  Endpoint endpoint;
  std::vector<std::uint8_t> heard;  // by the device
};

using PumpedEndpoint = Pumped<PtyEndpoint>;

}  // namespace virtdrive
