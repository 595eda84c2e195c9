#include "pty/tcp_endpoint.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <utility>

#include "core/check.h"

namespace virtdrive {
namespace {

constexpr const char* kLoopback = "127.0.0.1";

struct HostAndPort {
  std::string host;
  std::string port;
};

SetupError no_listener(const std::string& address, const std::string& why) {
  return SetupError(fmt::format("cannot listen at '{}': {}", address, why));
}

bool is_port(const std::string& text) {
  unsigned port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc{} && end == text.data() + text.size() && port <= 65535;
}

HostAndPort parse_address(const std::string& address) {
  const std::size_t colon = address.rfind(':');
  HostAndPort parsed{kLoopback, address};
  if (colon != std::string::npos) {
    parsed.port = address.substr(colon + 1);
    if (colon > 0) parsed.host = address.substr(0, colon);
  }
  std::string& host = parsed.host;
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  if (bracketed) host = host.substr(1, host.size() - 2);
  const bool loose_ipv6 = !bracketed && host.find(':') != std::string::npos;
  if (!is_port(parsed.port) || loose_ipv6) {
    throw no_listener(address,
                      "expected HOST:PORT, [IPv6]:PORT or PORT with a port of 0 (any free one) to "
                      "65535, such as 127.0.0.1:5555");
  }
  return parsed;
}

std::string remedy(int error) {
  switch (error) {
    case EADDRINUSE:
      return "another program has this port; stop it, choose another port, or 0 for any free one";
    case EACCES:
      return "you may not have this port; choose one above 1023";
    case EADDRNOTAVAIL:
      return "this machine has no such address; take 127.0.0.1, or 0.0.0.0 to be reached from "
             "other machines";
    default:
      return std::strerror(error);
  }
}

FileDescriptor listen_at(const std::string& address) {
  const HostAndPort parsed = parse_address(address);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV;
  addrinfo* found = nullptr;
  const int error = getaddrinfo(parsed.host.c_str(), parsed.port.c_str(), &hints, &found);
  if (error != 0) {
    throw no_listener(address, fmt::format("there is no host '{}' ({}); take 127.0.0.1",
                                           parsed.host, gai_strerror(error)));
  }
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> owner{found, &freeaddrinfo};

  FileDescriptor listener{
      socket(found->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, IPPROTO_TCP)};
  const int on = 1;  // or a restart would have to wait for the last client's connection to expire
  if (!listener || setsockopt(listener.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) != 0 ||
      bind(listener.get(), found->ai_addr, found->ai_addrlen) != 0 ||
      listen(listener.get(), 16) != 0) {
    throw no_listener(address, remedy(errno));
  }
  return listener;
}

std::string bound_address(int listener) {
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  std::array<char, NI_MAXHOST> host{};
  std::array<char, NI_MAXSERV> port{};
  auto* const generic = reinterpret_cast<sockaddr*>(&bound);
  VIRTDRIVE_CHECK(getsockname(listener, generic, &size) == 0 &&
                      getnameinfo(generic, size, host.data(), host.size(), port.data(), port.size(),
                                  NI_NUMERICHOST | NI_NUMERICSERV) == 0,
                  "the address of a listening socket: {}", std::strerror(errno));
  return bound.ss_family == AF_INET6 ? fmt::format("[{}]:{}", host.data(), port.data())
                                     : fmt::format("{}:{}", host.data(), port.data());
}

void set_option(int socket, int level, int option, int value) {
  setsockopt(socket, level, option, &value, sizeof value);
}

// A reply leaves at once; a peer whose machine is gone is noticed within a minute; and no more than
// a serial driver would hold waits in the kernel (which doubles the number).
void set_up_client(int client) {
  set_option(client, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(client, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(client, IPPROTO_TCP, TCP_KEEPIDLE, 30);
  set_option(client, IPPROTO_TCP, TCP_KEEPINTVL, 10);
  set_option(client, IPPROTO_TCP, TCP_KEEPCNT, 3);
  set_option(client, SOL_SOCKET, SO_SNDBUF, 8192);
}

void watch(int epoll, int operation, int fd, std::uint32_t events) {
  epoll_event event{};
  event.events = events;
  event.data.fd = fd;
  VIRTDRIVE_CHECK(epoll_ctl(epoll, operation, fd, &event) == 0, "epoll_ctl: {}",
                  std::strerror(errno));
}

}  // namespace

TcpEndpoint::TcpEndpoint(SerialLine& line, const std::string& address, TcpMode mode)
    : line_(line),
      mode_(mode),
      listener_(listen_at(address)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      address_(bound_address(listener_.get())) {
  if (!epoll_) throw no_listener(address, std::strerror(errno));
  watch(epoll_.get(), EPOLL_CTL_ADD, listener_.get(), EPOLLIN);
  line_.on_host_byte([this](std::uint8_t byte, SimTime) {
    if (!client_) {
      ++counters_.unheard;
    } else if (outbox_.pending.size() == kMaxPending) {
      ++counters_.overrun;
    } else {
      outbox_.pending.push_back(byte);
    }
  });
}

TcpEndpoint::~TcpEndpoint() {
  line_.on_host_byte(nullptr);
}

// The client first: when it has gone, the next one may have come in the same moment.
void TcpEndpoint::readable() {
  std::array<epoll_event, 2> events{};
  const int count = epoll_wait(epoll_.get(), events.data(), events.size(), 0);
  bool knocked = false;
  for (int i = 0; i < count; ++i) {
    if (events[i].data.fd == listener_.get()) {
      knocked = true;
      continue;
    }
    if ((events[i].events & EPOLLIN) != 0) read_client();
    if ((events[i].events & (EPOLLHUP | EPOLLERR)) != 0) session_ends();
  }
  if (knocked) accept_clients();
}

void TcpEndpoint::flush() {
  if (!client_) return;
  if (outbox_.wire.size() < kMaxPending) {
    if (session_) {
      session_->encode_pending();
    } else {
      outbox_.wire.insert(outbox_.wire.end(), outbox_.pending.begin(), outbox_.pending.end());
      outbox_.pending.clear();
    }
  }
  if (!outbox_.wire.empty()) {
    const ssize_t sent =
        send(client_.get(), outbox_.wire.data(), outbox_.wire.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) outbox_.wire.erase(outbox_.wire.begin(), outbox_.wire.begin() + sent);
    if (sent < 0 && errno != EAGAIN && errno != EINTR) {
      session_ends();
      return;
    }
  }
  rearm();
}

void TcpEndpoint::read_client() {
  constexpr int kMaxReads = 16;  // telnet commands take no room in the line: not for ever
  std::array<std::uint8_t, kMaxBacklog> bytes;
  for (int i = 0; i < kMaxReads; ++i) {
    const std::size_t room = kMaxBacklog - std::min(kMaxBacklog, line_.host_backlog());
    if (finished_ || room == 0 || outbox_.wire.size() >= kMaxPending) return;
    const ssize_t size = recv(client_.get(), bytes.data(), room, MSG_DONTWAIT);
    if (size < 0) {
      if (errno != EAGAIN && errno != EINTR) session_ends();
      return;
    }
    finished_ = size == 0;
    const std::span heard = std::span(bytes).first(static_cast<std::size_t>(size));
    if (session_) {
      counters_.ignored += session_->hear(heard);
    } else if (!heard.empty()) {
      line_.host_send(heard);
    }
  }
}

void TcpEndpoint::accept_clients() {
  constexpr int kMaxAtOnce = 16;
  for (int i = 0; i < kMaxAtOnce; ++i) {
    FileDescriptor client{accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)};
    if (!client) return;
    if (attached()) {
      ++counters_.refused;
    } else {
      session_ends();
      session_begins(std::move(client));
    }
  }
}

void TcpEndpoint::session_begins(FileDescriptor client) {
  set_up_client(client.get());
  client_ = std::move(client);
  armed_ = EPOLLIN;
  watch(epoll_.get(), EPOLL_CTL_ADD, client_.get(), armed_);
  if (mode_ == TcpMode::kRfc2217) session_.emplace(line_, outbox_);
  ++counters_.attached;
}

void TcpEndpoint::session_ends() {
  client_.reset();
  session_.reset();
  outbox_ = {};
  finished_ = false;
  line_.set_host({});
}

// Waits for room in the kernel's buffer, and leaves the client's bytes there while enough are
// queued. A finished client would be readable for ever.
void TcpEndpoint::rearm() {
  const bool listens =
      !finished_ && line_.host_backlog() < kMaxBacklog && outbox_.wire.size() < kMaxPending;
  const std::uint32_t wanted = (listens ? std::uint32_t{EPOLLIN} : 0U) |
                               (outbox_.wire.empty() ? 0U : std::uint32_t{EPOLLOUT});
  if (wanted == armed_) return;
  watch(epoll_.get(), EPOLL_CTL_MOD, client_.get(), wanted);
  armed_ = wanted;
}

}  // namespace virtdrive
