#include "pty/host_port.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <poll.h>

#include "core/check.h"
#include "pty/tty_settings.h"

namespace virtdrive {
namespace {

using Clock = std::chrono::steady_clock;

/// False when the deadline has passed before the descriptor was ready.
bool wait_for(int fd, short events, Clock::time_point deadline) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
    pollfd descriptor{fd, events, 0};
    const int ready =
        poll(&descriptor, 1, static_cast<int>(std::max<std::int64_t>(0, left.count())));
    if (ready > 0) return true;
    if (ready == 0 && left.count() <= 0) return false;
  }
}

}  // namespace

HostPort::HostPort(const std::string& path, int baud)
    : path_(path), tty_(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
  if (!tty_) {
    throw SetupError(
        fmt::format("cannot open the port '{}': {}; does the bench run, and is this "
                    "the name it printed?",
                    path, std::strerror(errno)));
  }
  if (!set_raw(tty_.get(), {baud, 1}, RawFor::kHost)) {
    throw SetupError(fmt::format("'{}' is no serial port: {}", path, std::strerror(errno)));
  }
}

void HostPort::write(std::span<const std::uint8_t> bytes) {
  constexpr std::chrono::seconds kPatience{1};
  while (!bytes.empty()) {
    const ssize_t written = ::write(tty_.get(), bytes.data(), bytes.size());
    if (written > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    } else if (errno != EAGAIN && errno != EINTR) {
      throw SetupError(fmt::format("the port '{}' is gone: {}", path_, std::strerror(errno)));
    } else if (!wait_for(tty_.get(), POLLOUT, Clock::now() + kPatience)) {
      throw SetupError(
          fmt::format("the port '{}' takes no bytes; does the bench still run?", path_));
    }
  }
}

std::vector<std::uint8_t> HostPort::read(std::size_t count, std::chrono::nanoseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 4096> part;
  while (bytes.size() < count && wait_for(tty_.get(), POLLIN, deadline)) {
    const ssize_t size =
        ::read(tty_.get(), part.data(), std::min(part.size(), count - bytes.size()));
    if (size > 0) {
      bytes.insert(bytes.end(), part.begin(), part.begin() + size);
    } else if (size == 0 || (errno != EAGAIN && errno != EINTR)) {
      throw SetupError(fmt::format("the port '{}' is gone", path_));
    }
  }
  return bytes;
}

std::optional<std::uint8_t> HostPort::read(SimDuration patience) {
  const std::vector<std::uint8_t> bytes = read(1, patience);
  if (bytes.empty()) return std::nullopt;
  return bytes.front();
}

}  // namespace virtdrive
