#include "pty/tty_settings.h"

#include <algorithm>
#include <array>
#include <asm/termbits.h>
#include <sys/ioctl.h>

namespace virtdrive {
namespace {

struct StandardBaud {
  int baud;
  tcflag_t code;
};

constexpr auto kStandardBauds = std::to_array<StandardBaud>({
    {50, B50},           {75, B75},           {110, B110},         {134, B134},
    {150, B150},         {200, B200},         {300, B300},         {600, B600},
    {1200, B1200},       {1800, B1800},       {2400, B2400},       {4800, B4800},
    {9600, B9600},       {19200, B19200},     {38400, B38400},     {57600, B57600},
    {115200, B115200},   {230400, B230400},   {460800, B460800},   {500000, B500000},
    {576000, B576000},   {921600, B921600},   {1000000, B1000000}, {1152000, B1152000},
    {1500000, B1500000}, {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000},
    {3500000, B3500000}, {4000000, B4000000},
});

// Programs that know only <termios.h> can read a rate back only as one of its constants.
tcflag_t baud_code(int baud) {
  for (const StandardBaud& standard : kStandardBauds) {
    if (standard.baud == baud) return standard.code;
  }
  return BOTHER;
}

constexpr std::array<tcflag_t, 4> kDataBits = {CS5, CS6, CS7, CS8};

tcflag_t parity_flags(Parity parity) {
  if (parity == Parity::kNone) return 0;
  return parity == Parity::kOdd ? PARENB | PARODD : PARENB;
}

}  // namespace

// glibc's tcsetattr fails with EINVAL if the kernel dropped PARENB, as it does on a
// pseudo-terminal, and nothing else changed. A host that asks for even parity would connect once
// and never again, and could not even set its time-out anew. So something is always left for it to
// change: most hosts ask for CLOCAL (pyserial, libmodbus, minicom), which has no effect here, and
// TIOCSSOFTCAR takes that one flag away atomically, so a setting that the host makes meanwhile is
// not undone. For hosts that do not, there is the preset of RawFor::kNobody.
TtySettings inspect_host(int master) {
  termios2 t{};
  if (ioctl(master, TCGETS2, &t) != 0) return {};
  if ((t.c_cflag & CLOCAL) != 0) {
    const int off = 0;
    ioctl(master, TIOCSSOFTCAR, &off);
  }
  return {static_cast<int>(t.c_ospeed), (t.c_cflag & CSTOPB) != 0 ? 2 : 1};
}

bool set_raw(int fd, const TtySettings& settings, RawFor whom) {
  termios2 t{};
  if (ioctl(fd, TCGETS2, &t) != 0) return false;
  // For nobody: IGNBRK without CLOCAL. A program that makes a terminal raw clears IGNBRK
  // (cfmakeraw, pyserial) or sets CLOCAL (minicom, libmodbus); no break and no carrier exist on a
  // pseudo-terminal, so neither flag does anything. See inspect_host for what it is good for.
  t.c_iflag = (whom == RawFor::kNobody ? IGNBRK : 0) |
              (settings.parity == Parity::kNone ? 0 : INPCK | IGNPAR);
  t.c_oflag = 0;
  t.c_lflag = 0;
  t.c_cflag = kDataBits[settings.data_bits - 5] | parity_flags(settings.parity) | CREAD |
              (whom == RawFor::kNobody ? 0 : CLOCAL) | (settings.stop_bits == 2 ? CSTOPB : 0) |
              baud_code(settings.baud);
  t.c_ispeed = t.c_ospeed = static_cast<speed_t>(settings.baud);
  t.c_cc[VMIN] = 1;
  t.c_cc[VTIME] = 0;
  return ioctl(fd, TCSETS2, &t) == 0;
}

TtySettings inspect_own(int fd) {
  termios2 t{};
  if (ioctl(fd, TCGETS2, &t) != 0) return {};
  const auto data_bits = std::ranges::find(kDataBits, t.c_cflag & CSIZE);
  return {.baud = static_cast<int>(t.c_ospeed),
          .stop_bits = (t.c_cflag & CSTOPB) != 0 ? 2 : 1,
          .data_bits = 5 + static_cast<int>(data_bits - kDataBits.begin()),
          .parity = (t.c_cflag & PARENB) == 0   ? Parity::kNone
                    : (t.c_cflag & PARODD) == 0 ? Parity::kEven
                                                : Parity::kOdd};
}

std::shared_ptr<const termios2> save_settings(int fd) {
  auto saved = std::make_shared<termios2>();
  if (ioctl(fd, TCGETS2, saved.get()) != 0) return nullptr;
  return saved;
}

void restore_settings(int fd, const std::shared_ptr<const termios2>& saved) {
  if (saved) ioctl(fd, TCSETS2, saved.get());
}

void drain(int fd) {
  ioctl(fd, TCSBRK, 1);  // what tcdrain() is
}

void discard_unread(int fd) {
  ioctl(fd, TCFLSH, TCIFLUSH);
}

}  // namespace virtdrive
