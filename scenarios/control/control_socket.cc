#include "scenarios/control/control_socket.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>
#include <utility>

#include "core/check.h"

namespace virtdrive {
namespace {

[[noreturn]] void fail(const std::string& path, std::string_view why) {
  throw SetupError(fmt::format("--control {}: {}", path, why));
}

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    fail(path, fmt::format("a socket's path has 1 ... {} bytes", sizeof address.sun_path - 1));
  }
  std::copy(path.begin(), path.end(), address.sun_path);
  return address;
}

FileDescriptor open_socket(int flags) {
  FileDescriptor fd{::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | flags, 0)};
  if (!fd) throw SetupError(fmt::format("cannot make a socket: {}", std::strerror(errno)));
  return fd;
}

bool connects(int fd, const sockaddr_un& address) {
  return ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
}

// Whatever is at the path is a socket that nobody listens to any more, or an error.
void remove_stale(const std::string& path, const sockaddr_un& address) {
  struct stat status{};
  if (::lstat(path.c_str(), &status) != 0) return;
  if (!S_ISSOCK(status.st_mode)) fail(path, "is there and is no socket; name another path");
  if (connects(open_socket(0).get(), address)) fail(path, "another bench is controlled there");
  ::unlink(path.c_str());
}

}  // namespace

ControlSocket::ControlSocket(const std::string& path, Answer answer)
    : path_(path),
      answer_(std::move(answer)),
      listener_(open_socket(SOCK_NONBLOCK)),
      epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
  const sockaddr_un address = address_of(path);
  remove_stale(path, address);
  const mode_t mask = ::umask(0177);  // the owner's alone from its first moment on
  const int bound =
      ::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const int error = errno;
  ::umask(mask);
  if (bound != 0) fail(path, std::strerror(error));
  if (!epoll_ || ::listen(listener_.get(), kMostClients) != 0) fail(path, std::strerror(errno));
  watch(listener_.get(), EPOLLIN, EPOLL_CTL_ADD);
}

ControlSocket::~ControlSocket() {
  ::unlink(path_.c_str());
}

void ControlSocket::watch(int fd, unsigned events, int operation) {
  epoll_event event{};
  event.events = events;
  event.data.fd = fd;
  ::epoll_ctl(epoll_.get(), operation, fd, &event);
}

void ControlSocket::readable() {
  accept_clients();
  for (Client& client : clients_) serve(client);
  clients_.remove_if([](const Client& client) { return client.gone; });
}

void ControlSocket::accept_clients() {
  while (true) {
    FileDescriptor fd{::accept4(listener_.get(), nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC)};
    if (!fd) return;
    if (clients_.size() >= kMostClients) continue;  // closed: turned away
    watch(fd.get(), EPOLLIN, EPOLL_CTL_ADD);
    clients_.push_back({.fd = std::move(fd), .heard = {}, .pending = {}});
  }
}

void ControlSocket::serve(Client& client) {
  char buffer[4096];
  while (!client.gone) {
    const ssize_t got = ::recv(client.fd.get(), buffer, sizeof buffer, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) break;
    if (got == 0) client.gone = true;
    client.heard.append(buffer, static_cast<std::size_t>(got));
    for (std::size_t end; (end = client.heard.find('\n')) != std::string::npos;) {
      client.pending += answer_(std::string_view(client.heard).substr(0, end)) + '\n';
      client.heard.erase(0, end + 1);
    }
    client.gone =
        client.gone || client.heard.size() > kMostRequest || client.pending.size() > kMostPending;
  }
  write(client);
}

void ControlSocket::write(Client& client) {
  while (!client.pending.empty()) {
    const ssize_t sent = ::send(client.fd.get(), client.pending.data(), client.pending.size(),
                                MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent < 0 && errno == EINTR) continue;
    if (sent < 0) {
      client.gone = client.gone || (errno != EAGAIN && errno != EWOULDBLOCK);
      break;
    }
    client.pending.erase(0, static_cast<std::size_t>(sent));
  }
  const unsigned more = client.pending.empty() ? 0U : static_cast<unsigned>(EPOLLOUT);
  watch(client.fd.get(), EPOLLIN | more, EPOLL_CTL_MOD);
}

std::string ask_control_socket(const std::string& path, std::string_view request) {
  const FileDescriptor fd = open_socket(0);
  if (!connects(fd.get(), address_of(path))) {
    throw SetupError(
        fmt::format("{}: no bench is controlled there: {}", path, std::strerror(errno)));
  }
  std::string line = std::string(request) + '\n';
  for (std::string_view rest = line; !rest.empty();) {
    const ssize_t sent = ::send(fd.get(), rest.data(), rest.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) throw SetupError(fmt::format("{}: the bench is gone", path));
    rest.remove_prefix(static_cast<std::size_t>(sent));
  }
  std::string answer;
  char buffer[4096];
  while (answer.find('\n') == std::string::npos) {
    const ssize_t got = ::recv(fd.get(), buffer, sizeof buffer, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw SetupError(fmt::format("{}: the bench ended without an answer", path));
    answer.append(buffer, static_cast<std::size_t>(got));
  }
  return answer.substr(0, answer.find('\n'));
}

}  // namespace virtdrive
