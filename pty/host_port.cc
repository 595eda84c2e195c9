#include "pty/host_port.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <string_view>
#include <sys/socket.h>

#include "core/check.h"
#include "pty/tty_settings.h"

namespace virtdrive {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::string_view kTcp = "tcp://";

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

// A socket whose peer has gone raises no signal.
ssize_t write_some(int fd, std::span<const std::uint8_t> bytes) {
  const ssize_t sent = send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  return sent < 0 && errno == ENOTSOCK ? ::write(fd, bytes.data(), bytes.size()) : sent;
}

FileDescriptor open_terminal(const std::string& path, const TtySettings& settings) {
  FileDescriptor tty(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!tty) {
    throw SetupError(
        fmt::format("cannot open the port '{}': {}; does the bench run, and is this "
                    "the name it printed?",
                    path, std::strerror(errno)));
  }
  if (!set_raw(tty.get(), settings, RawFor::kHost)) {
    throw SetupError(fmt::format("'{}' is no serial port: {}", path, std::strerror(errno)));
  }
  return tty;
}

FileDescriptor connect_to(const std::string& address) {
  const auto failed = [&](const std::string& why) {
    return SetupError(fmt::format("cannot connect to '{}': {}", address, why));
  };
  std::string host = address.substr(kTcp.size());
  const std::size_t colon = host.rfind(':');
  if (colon == std::string::npos) throw failed("expected tcp://HOST:PORT");
  const std::string port = host.substr(colon + 1);
  host.resize(colon);
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);

  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &hints, &found); error != 0) {
    throw failed(gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner{found, &freeaddrinfo};
  FileDescriptor socket(::socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC, IPPROTO_TCP));
  if (!socket || connect(socket.get(), found->ai_addr, found->ai_addrlen) != 0) {
    throw failed(fmt::format("{}; does the bench run with --tcp there?", std::strerror(errno)));
  }
  const int on = 1;  // a request leaves at once
  setsockopt(socket.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
  fcntl(socket.get(), F_SETFL, O_NONBLOCK);
  return socket;
}

}  // namespace

HostPort::HostPort(const std::string& address, const TtySettings& settings)
    : address_(address),
      port_(address.starts_with(kTcp) ? connect_to(address) : open_terminal(address, settings)) {}

void HostPort::set(const TtySettings& settings) {
  if (isatty(port_.get()) == 0) return;
  drain(port_.get());
  if (!set_raw(port_.get(), settings, RawFor::kHost)) {
    throw SetupError(fmt::format("the port '{}' cannot be set to {} baud: {}", address_,
                                 settings.baud, std::strerror(errno)));
  }
}

void HostPort::write(std::span<const std::uint8_t> bytes) {
  constexpr std::chrono::seconds kPatience{1};
  while (!bytes.empty()) {
    const ssize_t written = write_some(port_.get(), bytes);
    if (written > 0) {
      bytes = bytes.subspan(static_cast<std::size_t>(written));
    } else if (errno != EAGAIN && errno != EINTR) {
      throw SetupError(fmt::format("the port '{}' is gone: {}", address_, std::strerror(errno)));
    } else if (!wait_for(port_.get(), POLLOUT, Clock::now() + kPatience)) {
      throw SetupError(
          fmt::format("the port '{}' takes no bytes; does the bench still run?", address_));
    }
  }
}

std::vector<std::uint8_t> HostPort::read(std::size_t count, std::chrono::nanoseconds timeout) {
  const Clock::time_point deadline = Clock::now() + timeout;
  std::vector<std::uint8_t> bytes;
  std::array<std::uint8_t, 4096> part;
  while (bytes.size() < count && wait_for(port_.get(), POLLIN, deadline)) {
    const ssize_t size =
        ::read(port_.get(), part.data(), std::min(part.size(), count - bytes.size()));
    if (size > 0) {
      bytes.insert(bytes.end(), part.begin(), part.begin() + size);
    } else if (size == 0 || (errno != EAGAIN && errno != EINTR)) {
      throw SetupError(fmt::format("the port '{}' is gone", address_));
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
