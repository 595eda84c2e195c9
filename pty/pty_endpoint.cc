#include "pty/pty_endpoint.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>

#include "core/check.h"

namespace virtdrive {
namespace {

SetupError no_terminal(const char* step) {
  return SetupError(
      fmt::format("cannot make a pseudo-terminal: {}: {}; is /dev/pts mounted and "
                  "/proc/sys/kernel/pty/max not reached?",
                  step, std::strerror(errno)));
}

FileDescriptor open_master() {
  FileDescriptor master{posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
  if (!master) throw no_terminal("posix_openpt");
  if (grantpt(master.get()) != 0) throw no_terminal("grantpt");
  if (unlockpt(master.get()) != 0) throw no_terminal("unlockpt");
  return master;
}

std::string slave_name(int master) {
  std::array<char, 128> name{};
  if (ptsname_r(master, name.data(), name.size()) != 0) throw no_terminal("ptsname");
  return name.data();
}

}  // namespace

PtyEndpoint::PtyEndpoint(SerialLine& line, const std::string& link)
    : line_(line),
      master_(open_master()),
      inotify_(inotify_init1(IN_NONBLOCK | IN_CLOEXEC)),
      epoll_(epoll_create1(EPOLL_CLOEXEC)),
      terminal_(slave_name(master_.get())) {
  if (!inotify_) throw no_terminal("inotify_init1");
  if (!epoll_) throw no_terminal("epoll_create1");
  open_slave();
  preset();

  terminal_watch_ = inotify_add_watch(inotify_.get(), terminal_.c_str(), IN_OPEN | IN_CLOSE);
  if (terminal_watch_ < 0) throw no_terminal("inotify_add_watch");
  // inotify merges an event into an equal one before it. Its folder's events, which come in
  // between, keep two opens of the terminal apart.
  inotify_add_watch(inotify_.get(), "/dev/pts", IN_OPEN | IN_CLOSE);

  epoll_event event{};
  event.events = EPOLLIN;
  event.data.fd = inotify_.get();
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, inotify_.get(), &event) != 0) {
    throw no_terminal("epoll_ctl");
  }
  event.data.fd = master_.get();
  if (epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, master_.get(), &event) != 0) {
    throw no_terminal("epoll_ctl");
  }
  armed_ = EPOLLIN;

  if (!link.empty()) link_ = std::make_unique<PortLink>(link, terminal_);
  line_.on_host_byte([this](std::uint8_t byte, SimTime) {
    if (!attached_) {
      ++counters_.unheard;
    } else if (pending_.size() == kMaxPending) {
      ++counters_.overrun;
    } else {
      pending_.push_back(byte);
    }
  });
}

PtyEndpoint::~PtyEndpoint() {
  line_.on_host_byte(nullptr);
}

const std::string& PtyEndpoint::path() const {
  return link_ ? link_->path() : terminal_;
}

void PtyEndpoint::readable() {
  std::array<epoll_event, 2> events{};
  const int count = epoll_wait(epoll_.get(), events.data(), events.size(), 0);
  Hints hints;
  bool spoken = false;
  for (int i = 0; i < count; ++i) {
    if (events[i].data.fd == inotify_.get()) hints = read_hints();
    if (events[i].data.fd == master_.get()) spoken = (events[i].events & EPOLLIN) != 0;
  }
  // What a host wrote before it left is read with the settings it left.
  if (spoken) spoken = read_host();
  const bool present = in_doubt(hints, spoken) ? host_present() : open_count_ > 1;
  update_attachment(present, hints.emptied);
}

void PtyEndpoint::flush() {
  if (!pending_.empty()) {
    const ssize_t written = ::write(master_.get(), pending_.data(), pending_.size());
    if (written > 0) pending_.erase(pending_.begin(), pending_.begin() + written);
    refresh_host_settings();
  }
  const bool drive_changed = preset_.baud != line_.settings().baud;
  if (drive_changed && !attached_) preset();
  rearm();
}

bool PtyEndpoint::read_host() {
  const std::size_t room = kMaxBacklog - std::min(kMaxBacklog, line_.host_backlog());
  if (room == 0) return false;
  std::array<std::uint8_t, kMaxBacklog> bytes;
  const ssize_t count = ::read(master_.get(), bytes.data(), room);
  if (count <= 0) return false;
  refresh_host_settings();
  line_.host_send(std::span(bytes).first(static_cast<std::size_t>(count)));
  return true;
}

// The master shows the host's baud rate and stop bits; parity and character size the kernel drops.
void PtyEndpoint::refresh_host_settings() {
  const TtySettings settings = inspect_host(master_.get());
  if (settings == host_settings_) return;
  host_settings_ = settings;
  line_.set_host({.baud = settings.baud, .stop_bits = settings.stop_bits});
}

// Waits for room in the kernel's queue, and leaves the host's bytes there while enough are queued.
void PtyEndpoint::rearm() {
  const std::uint32_t wanted = (line_.host_backlog() < kMaxBacklog ? std::uint32_t{EPOLLIN} : 0U) |
                               (pending_.empty() ? 0U : std::uint32_t{EPOLLOUT});
  if (wanted == armed_) return;
  epoll_event event{};
  event.events = wanted;
  event.data.fd = master_.get();
  epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, master_.get(), &event);
  armed_ = wanted;
}

PtyEndpoint::Hints PtyEndpoint::read_hints() {
  Hints hints;
  alignas(inotify_event) std::array<char, 4096> buffer;
  for (;;) {
    const ssize_t size = ::read(inotify_.get(), buffer.data(), buffer.size());
    if (size <= 0) return hints;
    for (ssize_t at = 0; at < size;) {
      inotify_event event;
      std::memcpy(&event, buffer.data() + at, sizeof event);
      at += static_cast<ssize_t>(sizeof event + event.len);
      if ((event.mask & IN_Q_OVERFLOW) != 0) hints.overflow = true;
      if (event.wd != terminal_watch_) continue;
      if ((event.mask & IN_OPEN) != 0) {
        ++hints.opened;
        ++open_count_;
      }
      if ((event.mask & IN_CLOSE) != 0) {
        ++hints.closed;
        open_count_ = std::max(open_count_ - 1, 0);  // 0: our own, in host_present
        if (open_count_ <= 1) hints.emptied = true;
      }
    }
  }
}

void PtyEndpoint::update_attachment(bool present, bool anew) {
  if (!present) {
    if (attached_ || anew) session_ends();
  } else if (!attached_ || anew) {  // a host that closes and opens faster than we look begins anew
    session_begins();
  }
}

// When the count goes to zero it is right, and is not looked into: our own reopening would coincide
// with that of a host that reconnects at once, and inotify may make one event of two at the same
// instant (seen: 2 of 200 reconnects).
bool PtyEndpoint::in_doubt(const Hints& hints, bool spoken) const {
  const bool one_of_several_left = hints.closed > 0 && !hints.emptied;
  const bool nobody_speaks = spoken && open_count_ <= 1 && hints.closed == 0;
  return hints.overflow || one_of_several_left || nobody_speaks;
}

// Drops our own slave descriptor: the master is hung up if and only if nobody else has one. Hosts
// that come or go meanwhile show as more events than our own, and we look again.
bool PtyEndpoint::host_present() {
  int exclusive = 0;
  ioctl(slave_.get(), TIOCGEXCL, &exclusive);
  ioctl(slave_.get(), TIOCNXCL);  // or we could not open it again
  bool present = false;
  constexpr int kMaxLooks = 64;  // a host that opens and closes without end gets the last answer
  for (int look = 0; look < kMaxLooks; ++look) {
    slave_.reset();
    read_hints();
    pollfd poll_master{master_.get(), 0, 0};
    poll(&poll_master, 1, 0);
    present = (poll_master.revents & POLLHUP) == 0;
    open_slave();
    const Hints since = read_hints();
    if (since.opened == 1 && since.closed == 0) break;
  }
  open_count_ = present ? std::max(open_count_, 2) : 1;
  if (present && exclusive != 0) ioctl(slave_.get(), TIOCEXCL);
  return present;
}

void PtyEndpoint::open_slave() {
  slave_ = FileDescriptor{::open(terminal_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC)};
  if (!slave_) throw no_terminal(terminal_.c_str());
}

// Only for the first host: a second one (stty -F) must not take a reply in flight from the first.
// The slave's input queue is the one to flush: on the master, TCOFLUSH does nothing and TCIOFLUSH
// takes the request that the host may already have written.
void PtyEndpoint::session_begins() {
  discard_unread(slave_.get());
  pending_.clear();
  attached_ = true;
  ++counters_.attached;
  refresh_host_settings();
}

void PtyEndpoint::session_ends() {
  attached_ = false;
  pending_.clear();
  ioctl(slave_.get(), TIOCNXCL);  // left on by a host that was killed, it locks the others out
  preset();
  discard_unread(slave_.get());
}

// A fresh terminal says 38400: programs that set nothing (cat, socat) would hear garbage.
void PtyEndpoint::preset() {
  preset_ = {line_.settings().baud, line_.settings().stop_bits};
  set_raw(slave_.get(), preset_, RawFor::kNobody);
  refresh_host_settings();
}

}  // namespace virtdrive
