// A terminal's settings by way of termios2, which carries any baud rate as a number.
//
// In a file of its own because <asm/termbits.h> and <termios.h> cannot be included together.
#pragma once

#include <cstdint>
#include <memory>

#include "pty/serial_line.h"

struct termios2;

namespace virtdrive {

struct TtySettings {
  int baud = 0;  // bit/s; 0: hung up (B0)
  int stop_bits = 1;
  int data_bits = 8;  // 5..8
  Parity parity = Parity::kNone;

  friend bool operator==(const TtySettings&, const TtySettings&) = default;
};

/// What a host has set the slave of this pseudo-terminal master to: baud rate and stop bits, which
/// is all that the kernel shows. Leaves CLOCAL cleared, so that the next program that asks for it,
/// with or without a parity, changes something (see .cc).
TtySettings inspect_host(int master);

enum class RawFor : std::uint8_t {
  kHost,    // what a host program asks for
  kNobody,  // raw as well, but with a combination of flags that no host asks for (see .cc)
};

/// No echo, no translation, no flow control; bytes whose parity is wrong are dropped. False (errno)
/// if `fd` is no terminal. What it cannot have, a driver leaves out without an error.
bool set_raw(int fd, const TtySettings& settings, RawFor whom);

/// What this terminal is set to.
TtySettings inspect_own(int fd);

/// Everything a terminal is set to; nothing if `fd` is none.
std::shared_ptr<const termios2> save_settings(int fd);
/// Sets it back at once. Does nothing with nothing.
void restore_settings(int fd, const std::shared_ptr<const termios2>& saved);

/// Waits until all that was written to the terminal has left.
void drain(int fd);
/// Throws away what the terminal's user has not read yet.
void discard_unread(int fd);

}  // namespace virtdrive
