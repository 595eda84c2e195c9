#include "pty/serial_device_endpoint.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/epoll.h>
#include <sys/file.h>
#include <sys/ioctl.h>

#include "core/check.h"

namespace virtdrive {
namespace {

SetupError unusable(const std::string& path, const std::string& why) {
  return SetupError(fmt::format("cannot use the serial port '{}': {}", path, why));
}

std::string remedy(int error) {
  switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
      return "there is none; is the adapter plugged in? (ls /dev/tty*)";
    case EACCES:
    case EPERM:
      return "you may not open it; join its group (often: sudo usermod -aG dialout $USER)";
    case EBUSY:
      return "another program has it; close that one";
    default:
      return std::strerror(error);
  }
}

FileDescriptor open_port(const std::string& path) {
  FileDescriptor port{::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (!port) throw unusable(path, remedy(errno));
  if (isatty(port.get()) == 0) {
    throw unusable(path, "it is not a serial port; expected one such as /dev/ttyUSB0");
  }
  // Programs that know nothing of locks are kept out by TIOCEXCL, root's by the lock.
  if (flock(port.get(), LOCK_EX | LOCK_NB) != 0) throw unusable(path, remedy(EBUSY));
  ioctl(port.get(), TIOCEXCL);
  return port;
}

TtySettings settings_of(const SerialLine& line) {
  const LineSettings& s = line.settings();
  return {s.baud, s.stop_bits, s.data_bits, s.parity};
}

std::string text_of(const TtySettings& s) {
  const char parity = s.parity == Parity::kNone ? 'N' : s.parity == Parity::kEven ? 'E' : 'O';
  return fmt::format("{} baud {}{}{}", s.baud, s.data_bits, parity, s.stop_bits);
}

}  // namespace

SerialDeviceEndpoint::SerialDeviceEndpoint(SerialLine& line, const std::string& path)
    : line_(line),
      path_(path),
      port_(open_port(path)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      found_(save_settings(port_.get())) {
  try {
    if (!epoll_) throw unusable(path_, std::strerror(errno));
    apply_settings();
    discard_unread(port_.get());
    epoll_event event{};
    armed_ = event.events = EPOLLIN;
    if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, port_.get(), &event) != 0) {
      throw unusable(path_, std::strerror(errno));
    }
  } catch (const SetupError&) {
    restore_settings(port_.get(), found_);
    ioctl(port_.get(), TIOCNXCL);
    throw;
  }
  line_.on_host_byte([this](std::uint8_t byte, SimTime) {
    if (pending_.size() == kMaxPending) {
      ++counters_.overrun;
    } else {
      pending_.push_back(byte);
    }
  });
}

SerialDeviceEndpoint::~SerialDeviceEndpoint() {
  line_.on_host_byte(nullptr);
  restore_settings(port_.get(), found_);
  ioctl(port_.get(), TIOCNXCL);
}

void SerialDeviceEndpoint::readable() {
  epoll_event event{};
  if (epoll_wait(epoll_.get(), &event, 1, 0) != 1) return;
  if ((event.events & EPOLLIN) != 0) read_port();
  if ((event.events & (EPOLLHUP | EPOLLERR)) != 0) alive_ = false;
  if (alive_) return;
  epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, port_.get(), nullptr);
  throw SetupError(
      fmt::format("the serial port '{}' is gone; plug the adapter in again and start anew", path_));
}

void SerialDeviceEndpoint::flush() {
  if (!alive_) return;
  if (settings_ != settings_of(line_)) {
    // What is still in the UART was said at the old rate.
    int unsent = 0;
    ioctl(port_.get(), TIOCOUTQ, &unsent);
    if (unsent > 0) return;
    apply_settings();
  }
  write_port();
  rearm();
}

void SerialDeviceEndpoint::read_port() {
  const std::size_t room = kMaxBacklog - std::min(kMaxBacklog, line_.host_backlog());
  if (room == 0) return;
  std::array<std::uint8_t, kMaxBacklog> bytes;
  const ssize_t count = ::read(port_.get(), bytes.data(), room);
  if (count > 0) {
    line_.host_send(std::span(bytes).first(static_cast<std::size_t>(count)));
  } else if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
    alive_ = false;
  }
}

// A port that is gone shows at the next readable().
void SerialDeviceEndpoint::write_port() {
  if (pending_.empty()) return;
  const ssize_t written = ::write(port_.get(), pending_.data(), pending_.size());
  if (written > 0) pending_.erase(pending_.begin(), pending_.begin() + written);
}

void SerialDeviceEndpoint::apply_settings() {
  const TtySettings wanted = settings_of(line_);
  if (!set_raw(port_.get(), wanted, RawFor::kHost)) {
    throw unusable(
        path_, fmt::format("it cannot be set to {}: {}", text_of(wanted), std::strerror(errno)));
  }
  // A driver takes what its hardware has, without an error.
  const TtySettings got = inspect_own(port_.get());
  const bool close = std::abs(got.baud - wanted.baud) <= kBaudTolerance * wanted.baud;
  if (!close || got.stop_bits != wanted.stop_bits || got.data_bits != wanted.data_bits ||
      got.parity != wanted.parity) {
    throw unusable(path_, fmt::format("the drive needs {}, and the port offers {}; take another "
                                      "adapter",
                                      text_of(wanted), text_of(got)));
  }
  settings_ = wanted;
}

// Waits for room in the kernel's queue, and leaves bytes there while enough are queued.
void SerialDeviceEndpoint::rearm() {
  const std::uint32_t wanted = (line_.host_backlog() < kMaxBacklog ? std::uint32_t{EPOLLIN} : 0U) |
                               (pending_.empty() ? 0U : std::uint32_t{EPOLLOUT});
  if (wanted == armed_) return;
  epoll_event event{};
  event.events = wanted;
  epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, port_.get(), &event);
  armed_ = wanted;
}

}  // namespace virtdrive
